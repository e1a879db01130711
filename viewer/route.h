#pragma once

#include "core/tracer.h"
#include "viewer/free_space.h"
#include "viewer/look_up.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace lightgrid {

/// A line by points at equal distances, relative to Scene::origin; at least two.
struct Route {
    std::vector<glm::vec3> points;
    double step = 0;  // metres between them

    [[nodiscard]] double length() const { return step * static_cast<double>(points.size() - 1); }
    /// The place at a distance along the line from its start.
    [[nodiscard]] glm::vec3 at(double distance) const;
};

/// Leads through free space from one place with a view to the next, the shorter ways with room and views preferred;
/// smooth. No points where there is nowhere to go.
[[nodiscard]] Route find_route(const Tracer& tracer, const LookUp& light, const FreeSpace& space);

}  // namespace lightgrid
