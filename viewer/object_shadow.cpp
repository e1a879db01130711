#include "viewer/object_shadow.h"

namespace lightgrid {
namespace {

/// In radii. The shadow of the distant light is (r / (0.25 d))^2 dark at most, see contact_shadow.glsl.
constexpr double reach = 64;

}  // namespace

bool ObjectShadow::reaches(const Box& box) const {
    const glm::dvec3 nearest = glm::clamp(glm::dvec3(center), box.min, box.max);
    return glm::distance(nearest, glm::dvec3(center)) < reach * static_cast<double>(radius);
}

void set_shadow(const Uniforms& uniforms, const ObjectShadow& shadow) {
    uniforms.set("shadow_center", shadow.center);
    uniforms.set("shadow_radius", shadow.radius);
    uniforms.set("shadow_direction", shadow.light.direction);
    uniforms.set("shadow_illuminance", shadow.light.illuminance);
    uniforms.set("shadow_ambient", shadow.light.ambient);
}

}  // namespace lightgrid
