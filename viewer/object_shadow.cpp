#include "viewer/object_shadow.h"

#include "core/sampling.h"

#include <algorithm>
#include <numbers>

namespace lightgrid {
namespace {

/// In radii. The shadow of the distant light is (r / (0.25 d))^2 dark at most (contact_shadow.glsl): 4 % here.
constexpr double reach = 20;

}  // namespace

bool ObjectShadow::reaches(const Box& box) const {
    const glm::dvec3 nearest = glm::clamp(glm::dvec3(center), box.min, box.max);
    return glm::distance(nearest, glm::dvec3(center)) < reach * static_cast<double>(radius);
}

void set_shadow(const Uniforms& uniforms, const ObjectShadow& shadow) {
    uniforms.set("shadow_center", shadow.center);
    uniforms.set("shadow_radius", shadow.radius);
    uniforms.set("shadow_reach", static_cast<float>(reach));
    uniforms.set("shadow_direction", shadow.light.direction);
    const float rest = std::max(std::numbers::pi_v<float> * luminance(shadow.light.ambient), 1e-30F);
    uniforms.set("shadow_contrast", std::min(luminance(shadow.light.illuminance) / rest, 1e4F));
}

}  // namespace lightgrid
