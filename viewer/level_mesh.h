#pragma once

#include "core/scene.h"
#include "viewer/look_up.h"

#include <glm/glm.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

/// A level as a graphics card wants it. No OpenGL here.
namespace lightgrid {

struct LevelVertex {
    glm::vec3 position{0};         // in its mesh's space
    glm::i16vec4 normal{0};        // 32767 is 1; w is padding
    glm::vec2 base_color_uv{0};    // each with its TextureUse's transform in it
    glm::vec2 emission_uv{0};      //
    glm::vec2 transmission_uv{0};  //
    glm::u16vec4 color{65535};     // 65535 is 1

    bool operator==(const LevelVertex&) const = default;
};

/// One call to draw: triangles of one material, in one place or in many.
struct LevelDraw {
    int material = 0;  // index in Scene::materials
    std::uint32_t first_index = 0;
    std::uint32_t index_count = 0;
    int first_instance = 0;  // in LevelMesh::instances
    int instance_count = 1;
    bool mirrored = false;  // counter-clockwise in the mesh's space is clockwise in the level
    Box bounds;             // of all instances, relative to Scene::origin
    /// The light of instance i at vertex v is row first_light + i * light_stride + v - first_vertex of the light table.
    std::uint32_t first_light = 0;
    std::uint32_t light_stride = 0;
    std::uint32_t first_vertex = 0;
};

/// The same for each place by itself.
[[nodiscard]] std::vector<LevelDraw> in_each_place(const LevelDraw& draw);

struct LevelMesh {
    std::vector<LevelVertex> vertices;
    std::vector<std::uint32_t> indices;  // three a triangle, into `vertices`
    std::vector<glm::mat4x3> instances;  // to positions relative to Scene::origin; the first is the identity
    std::vector<LevelDraw> draws;
    std::uint32_t light_rows = 0;  // of the light table: a vertex in two places has two
    double longest_edge = 0;       // that was kept to, metres
};

/// The most rows of light unless the level itself has more: beyond, longer edges are left as they are.
inline constexpr std::uint32_t most_light_rows = 400'000;
/// Faces that meet at less than this are one smooth surface.
inline constexpr double level_crease_deg = 40;

/// Triangles of the level, divided until no edge is longer than `longest_edge` (so that light at the vertices has
/// somewhere to live), or longer than what most_light_rows allow. What divides an edge is its length alone, so that
/// neighbours stay joined. Instances are not copied.
///
/// Normals are of the front (counter-clockwise) side: geometric, averaged by angle over the faces around a vertex that
/// meet at less than level_crease_deg. (Files' own normals are no part of a Scene: light does not read them.)
///
/// longest_edge  metres, positive; infinite leaves every triangle whole
[[nodiscard]] LevelMesh build_level_mesh(const Scene& scene, double longest_edge,
                                         std::uint32_t most_rows = most_light_rows);

/// Irradiance on both sides of a surface at a vertex, lux, not negative, and its standard error (surface_error): as the
/// card's table has it.
struct VertexLight {
    glm::vec4 front{0};
    glm::vec4 back{0};
};

/// One for every row of the light table. In parallel.
///
/// value  of a side of the surface, by the place in level coordinates and the normal
[[nodiscard]] std::vector<VertexLight> light_level(const LevelMesh& mesh, glm::dvec3 origin,
                                                   const std::function<glm::vec4(glm::dvec3, glm::vec3)>& value);
/// The same by look-ups moved off the surface by `look_up`'s normal bias.
[[nodiscard]] std::vector<VertexLight> light_level(const LevelMesh& mesh, glm::dvec3 origin, const LookUp& look_up);

}  // namespace lightgrid
