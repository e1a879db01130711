#pragma once

#include "core/scene.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace lightgrid {

/// Triangles of one material, and the vertices that they and no others use.
struct ObjectDraw {
    int material = 0;  // index in ObjectMesh::materials
    std::uint32_t first_vertex = 0;
    std::uint32_t vertex_count = 0;
    std::uint32_t first_triangle = 0;
    std::uint32_t triangle_count = 0;
};

/// A thing that moves through a level. Its own axes, metres; counter-clockwise is the front.
struct ObjectMesh {
    std::string name;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;       // unit length, smooth but at creases (normals.h)
    std::vector<glm::vec2> uvs;           // for base colour, with its texture's transform in it
    std::vector<glm::vec2> emission_uvs;  // likewise for emission
    std::vector<glm::vec4> colors;        // linear, times the material's; 1 where the file has none
    std::vector<glm::uvec3> triangles;    // indices into all of the above
    std::vector<ObjectDraw> draws;
    std::vector<Material> materials;  // texture transforms are in the UVs already
    std::vector<Texture> textures;
    std::vector<std::string> notices;  // for the user
};

/// A white sphere of diameter 1 about the origin, poles along y. Normals are the sphere's own.
///
/// segments  around the poles, an even number of at least 4
[[nodiscard]] ObjectMesh make_sphere(unsigned segments = 64);

/// The Stanford bunny of the Debian package glmark2-data, where it is installed.
[[nodiscard]] std::optional<std::filesystem::path> find_bunny();

/// Reads .obj by obj.h, all else by load_level; both say what they take. Instances become triangles of the object's
/// own; its lights are left out. Throws Error, also where there is no triangle at all.
[[nodiscard]] ObjectMesh load_object(const std::filesystem::path& path);

/// A scene as one object, in positions relative to Scene::origin.
[[nodiscard]] ObjectMesh object_from_scene(const Scene& scene);

/// Scales and moves an object so that the middle of its bounds is at zero and their largest side is as long as this.
///
/// size  metres, positive
void fit(ObjectMesh& object, double size);

/// The object alone as a level for rays: one mesh per draw, its vertices and triangles in their order.
[[nodiscard]] Scene scene_from_object(const ObjectMesh& object);

}  // namespace lightgrid
