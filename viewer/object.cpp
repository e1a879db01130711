#include "viewer/object.h"

#include "core/error.h"
#include "core/gltf.h"
#include "core/near_names.h"
#include "viewer/normals.h"
#include "viewer/obj.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <unordered_map>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

/// All that tells one vertex from another.
struct Vertex {
    glm::vec3 position{0};
    glm::vec3 normal{0};
    glm::vec2 uv{0};
    glm::vec2 emission_uv{0};
    glm::vec4 color{1};

    bool operator==(const Vertex&) const = default;
};

struct HashVertex {
    std::size_t operator()(const Vertex& vertex) const {
        return std::hash<std::string_view>()({reinterpret_cast<const char*>(&vertex), sizeof vertex});
    }
};
static_assert(sizeof(Vertex) == 14 * sizeof(float), "hashed as bytes: no padding");

/// Triangles of one material before equal vertices are joined.
struct Soup {
    std::vector<Vertex> corners;  // three a triangle, without normals
};

glm::vec2 uv_of(const Mesh& mesh, const TextureUse& use, std::uint32_t vertex) {
    if (!use.used()) return glm::vec2(0);
    return use.transform * glm::vec3(mesh.uv_sets[static_cast<std::size_t>(use.uv_set)][vertex], 1);
}

void add(const Scene& scene, const Mesh& mesh, const glm::mat4x3& to_level, bool mirrored,
         std::map<int, Soup>& by_material) {
    const Material& material = scene.materials[static_cast<std::size_t>(mesh.material)];
    Soup& soup = by_material[mesh.material];
    for (const glm::uvec3& triangle : mesh.triangles) {
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t i = triangle[mirrored ? 2 - k : k];
            Vertex vertex;
            vertex.position = to_level * glm::vec4(mesh.positions[i], 1) + 0.0F;  // minus zero is zero
            vertex.uv = uv_of(mesh, material.base_color_texture, i);
            vertex.emission_uv = uv_of(mesh, material.emission_texture, i);
            if (!mesh.colors.empty()) vertex.color = glm::vec4(mesh.colors[i]) / 65535.0F;
            soup.corners.push_back(vertex);
        }
    }
}

/// Normals for all soups together: a surface may go on in another material.
void add_normals(std::map<int, Soup>& by_material) {
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
    for (const auto& entry : by_material) {
        for (const Vertex& corner : entry.second.corners) positions.push_back(corner.position);
    }
    for (std::uint32_t i = 0; i + 2 < positions.size(); i += 3) triangles.emplace_back(i, i + 1, i + 2);
    const auto normals = corner_normals(positions, triangles);
    std::size_t i = 0;
    for (auto& entry : by_material) {
        for (Vertex& corner : entry.second.corners) {
            corner.normal = normals[i / 3][i % 3];
            ++i;
        }
    }
}

void add_draw(int material, const Soup& soup, ObjectMesh& object) {
    ObjectDraw draw;
    draw.material = material;
    draw.first_vertex = static_cast<std::uint32_t>(object.positions.size());
    draw.first_triangle = static_cast<std::uint32_t>(object.triangles.size());
    draw.triangle_count = static_cast<std::uint32_t>(soup.corners.size() / 3);
    std::unordered_map<Vertex, std::uint32_t, HashVertex> known;
    std::vector<std::uint32_t> indices;
    for (const Vertex& vertex : soup.corners) {
        const auto [found, is_new] = known.try_emplace(vertex, static_cast<std::uint32_t>(object.positions.size()));
        indices.push_back(found->second);
        if (!is_new) continue;
        object.positions.push_back(vertex.position);
        object.normals.push_back(vertex.normal);
        object.uvs.push_back(vertex.uv);
        object.emission_uvs.push_back(vertex.emission_uv);
        object.colors.push_back(vertex.color);
    }
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        object.triangles.emplace_back(indices[i], indices[i + 1], indices[i + 2]);
    }
    draw.vertex_count = static_cast<std::uint32_t>(object.positions.size()) - draw.first_vertex;
    object.draws.push_back(draw);
}

bool is_obj(const fs::path& path) {
    return lower_case(path.extension().string()) == ".obj";
}

}  // namespace

ObjectMesh make_sphere(unsigned segments) {
    ObjectMesh sphere;
    sphere.name = "sphere";
    sphere.materials.emplace_back();
    const unsigned rings = segments / 2;
    for (unsigned ring = 0; ring <= rings; ++ring) {
        for (unsigned i = 0; i <= segments; ++i) {  // the seam twice, for the UVs
            const double polar = glm::pi<double>() * ring / rings;
            const double azimuth = glm::two_pi<double>() * (i % segments) / segments;
            const bool pole = ring == 0 || ring == rings;
            const double radius = pole ? 0 : std::sin(polar);
            const glm::dvec3 normal(radius * std::cos(azimuth), std::cos(polar), radius * std::sin(azimuth));
            sphere.positions.emplace_back(0.5 * normal);
            sphere.normals.emplace_back(normal);
            sphere.uvs.emplace_back(static_cast<double>(i) / segments, static_cast<double>(ring) / rings);
        }
    }
    const auto at = [&](unsigned ring, unsigned i) { return ring * (segments + 1) + i; };
    for (unsigned ring = 0; ring < rings; ++ring) {
        for (unsigned i = 0; i < segments; ++i) {
            if (ring > 0) sphere.triangles.emplace_back(at(ring, i), at(ring, i + 1), at(ring + 1, i));
            if (ring + 1 < rings) {
                sphere.triangles.emplace_back(at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i));
            }
        }
    }
    sphere.emission_uvs = sphere.uvs;
    sphere.colors.assign(sphere.positions.size(), glm::vec4(1));
    sphere.draws.push_back({0, 0, static_cast<std::uint32_t>(sphere.positions.size()), 0,
                            static_cast<std::uint32_t>(sphere.triangles.size())});
    return sphere;
}

std::optional<fs::path> find_bunny() {
    const fs::path path = "/usr/share/glmark2/models/bunny.obj";
    std::error_code none;
    if (!fs::is_regular_file(path, none)) return std::nullopt;
    return path;
}

ObjectMesh object_from_scene(const Scene& scene) {
    std::map<int, Soup> by_material;
    for (const int mesh : scene.placed) add(scene, scene.meshes[mesh], glm::mat4x3(1), false, by_material);
    for (const Instance& instance : scene.instances) {
        for (const int mesh : scene.models[static_cast<std::size_t>(instance.model)].meshes) {
            add(scene, scene.meshes[mesh], instance.to_level, instance.mirrored, by_material);
        }
    }
    std::erase_if(by_material, [](const auto& entry) { return entry.second.corners.empty(); });
    if (by_material.empty()) throw Error("no triangles", scene.name, "An object needs a surface.");
    add_normals(by_material);

    ObjectMesh object;
    object.name = scene.name;
    object.textures = scene.textures;
    object.notices = scene.notices;
    object.materials = scene.materials;
    for (Material& material : object.materials) {
        for (TextureUse* use : {&material.base_color_texture, &material.emission_texture}) {
            use->uv_set = 0;
            use->transform = TextureUse{}.transform;
        }
    }
    for (const auto& [material, soup] : by_material) add_draw(material, soup, object);
    if (!scene.lights.empty()) object.notices.emplace_back("an object's lights are not part of it");
    return object;
}

ObjectMesh load_object(const fs::path& path) {
    LoadOptions white;  // an object without materials has glTF's own
    white.default_albedo = 1;
    return object_from_scene(is_obj(path) ? load_obj(path) : load_level(path, white));
}

void fit(ObjectMesh& object, double size) {
    Box bounds;
    for (const glm::vec3& position : object.positions) bounds.extend(position);
    const glm::dvec3 extent = bounds.size();
    const double largest = std::max({extent.x, extent.y, extent.z});
    const double scale = largest > 0 ? size / largest : 1;
    for (glm::vec3& position : object.positions) {
        position = glm::vec3(scale * (glm::dvec3(position) - bounds.center()));
    }
}

Scene scene_from_object(const ObjectMesh& object) {
    Scene scene;
    scene.name = object.name;
    scene.materials = object.materials;
    scene.textures = object.textures;
    for (const ObjectDraw& draw : object.draws) {
        const auto part = [&](const auto& all) {
            const auto first = all.begin() + draw.first_vertex;
            return std::vector(first, first + draw.vertex_count);
        };
        Mesh mesh;
        mesh.material = draw.material;
        mesh.positions = part(object.positions);
        mesh.positions.reserve(mesh.positions.size() + 1);
        mesh.uv_sets = {part(object.uvs), part(object.emission_uvs)};
        for (const glm::vec4& color : part(object.colors)) {
            mesh.colors.emplace_back(glm::round(65535.0F * glm::clamp(color, 0.0F, 1.0F)));
        }
        for (std::uint32_t t = 0; t < draw.triangle_count; ++t) {
            mesh.triangles.push_back(object.triangles[draw.first_triangle + t] - draw.first_vertex);
        }
        scene.placed.push_back(static_cast<int>(scene.meshes.size()));
        scene.meshes.push_back(std::move(mesh));
    }
    for (const glm::vec3& position : object.positions) scene.bounds.extend(position);
    for (Material& material : scene.materials) {
        material.emission_texture.uv_set = 1;
        // Its UVs are not kept; for rays, what transmits does so everywhere alike.
        material.transmission_texture = {};
    }
    return scene;
}

}  // namespace lightgrid
