#include "tools/ground.h"

#include <cmath>

namespace lightgrid {

std::optional<float> height_above_ground(const Tracer& tracer, glm::vec3 point) {
    constexpr float least_cosine = 0.5F;
    constexpr glm::vec3 down(0, -1, 0);
    const Hit hit = tracer.closest_hit(point, down);
    if (!hit.found() || std::abs(tracer.surface(hit, down).normal.y) < least_cosine) return {};
    return hit.distance;
}

}  // namespace lightgrid
