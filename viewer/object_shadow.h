#pragma once

#include "core/scene.h"
#include "viewer/dominant_light.h"
#include "viewer/gl_objects.h"
#include "viewer/level_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace lightgrid {

/// What an object, taken for a sphere, hides of the light of surfaces around it: what contact_shadow.glsl asks for.
struct ObjectShadow {
    glm::vec3 center{0};  // relative to Scene::origin
    float radius = 0;     // metres
    DominantLight light;  // at the centre

    /// Some of a box, or of a ball round a point (both relative to Scene::origin), may be darkened.
    [[nodiscard]] bool reaches(const Box& box) const;
    [[nodiscard]] bool reaches(glm::vec3 at, float around) const;
};

/// Triangles of draws, told apart by whether the shadow may darken them: each draw is one of a single place.
struct ShadowSplit {
    std::vector<LevelDraw> shaded;       // first_index counts in `indices`
    std::vector<LevelDraw> others;       //
    std::vector<std::uint32_t> indices;  // three a triangle, into LevelMesh::vertices
};

[[nodiscard]] ShadowSplit split_by_shadow(const LevelMesh& mesh, std::span<const LevelDraw* const> draws,
                                          const ObjectShadow& shadow);

void set_shadow(const Uniforms& uniforms, const ObjectShadow& shadow);

}  // namespace lightgrid
