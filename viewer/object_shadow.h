#pragma once

#include "core/scene.h"
#include "viewer/dominant_light.h"
#include "viewer/gl_objects.h"

#include <glm/glm.hpp>

namespace lightgrid {

/// What an object, taken for a sphere, hides of the light of surfaces around it: what contact_shadow.glsl asks for.
struct ObjectShadow {
    glm::vec3 center{0};  // relative to Scene::origin
    float radius = 0;     // metres
    DominantLight light;  // at the centre

    /// Some of a box (relative to Scene::origin) may be darkened.
    [[nodiscard]] bool reaches(const Box& box) const;
};

void set_shadow(const Uniforms& uniforms, const ObjectShadow& shadow);

}  // namespace lightgrid
