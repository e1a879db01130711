#include "viewer/obj.h"

#include "core/error.h"

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

std::vector<std::byte> read_bytes(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw Error("cannot be read", path.string());
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    const auto* first = reinterpret_cast<const std::byte*>(bytes.data());
    return {first, first + bytes.size()};
}

/// Notices, one a line, of what the parser says.
void note_lines(const std::string& text, Scene& scene) {
    std::size_t start = 0;
    while (start < text.size()) {
        const std::size_t end = std::min(text.find('\n', start), text.size());
        if (end > start) scene.notices.push_back(text.substr(start, end - start));
        start = end + 1;
    }
}

/// Pictures by name, loaded once.
class Pictures {
  public:
    Pictures(fs::path folder, Scene& scene) : folder_(std::move(folder)), scene_(scene) {}

    TextureUse use(const std::string& name) {
        TextureUse result;
        if (name.empty()) return result;
        const auto [found, is_new] = textures_.try_emplace(name, -1);
        if (is_new) {
            try {
                const fs::path path = folder_ / name;
                scene_.textures.push_back({decode_image(read_bytes(path), path.string())});
                found->second = static_cast<int>(scene_.textures.size()) - 1;
            } catch (const Error& error) {
                scene_.notices.push_back(fmt::format("{} Left out.", error.what()));
            }
        }
        result.texture = found->second;
        return result;
    }

  private:
    fs::path folder_;
    Scene& scene_;
    std::map<std::string, int> textures_;
};

Material material_of(const tinyobj::material_t& source, Pictures& pictures) {
    Material material;
    material.name = source.name;
    material.base_color = {source.diffuse[0], source.diffuse[1], source.diffuse[2]};
    material.base_color_texture = pictures.use(source.diffuse_texname);
    // Exporters write Kd 0 beside a picture and mean the picture.
    if (material.base_color_texture.used() && material.base_color == glm::vec3(0)) material.base_color = glm::vec3(1);
    material.emission = {source.emission[0], source.emission[1], source.emission[2]};
    material.emission_texture = pictures.use(source.emissive_texname);
    material.alpha = source.dissolve;
    if (source.dissolve < 1) material.alpha_mode = AlphaMode::blend;
    return material;
}

bool is_finite(glm::vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool has_area(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
    return glm::cross(b - a, c - a) != glm::dvec3(0);
}

/// The corners of one triangle into the mesh of its material.
class Corners {
  public:
    Corners(const tinyobj::attrib_t& attributes, const fs::path& path) : attributes_(attributes), path_(path) {}

    [[nodiscard]] glm::vec3 position(tinyobj::index_t index) const {
        const glm::vec3 p = triple(attributes_.vertices, index.vertex_index, "vertex");
        if (!is_finite(p)) {
            throw Error(fmt::format("vertex {} is not finite", index.vertex_index + 1), path_.string());
        }
        return p;
    }
    [[nodiscard]] glm::vec2 uv(tinyobj::index_t index) const {
        const auto i = static_cast<std::size_t>(index.texcoord_index);
        if (index.texcoord_index < 0 || 2 * i + 1 >= attributes_.texcoords.size()) return glm::vec2(0);
        // From the lower left here, from the upper left in a Scene.
        return {attributes_.texcoords[2 * i], 1 - attributes_.texcoords[2 * i + 1]};
    }
    [[nodiscard]] glm::u16vec4 color(tinyobj::index_t index) const {
        const glm::vec3 color = triple(attributes_.colors, index.vertex_index, "colour");
        return {glm::u16vec3(glm::round(65535.0F * glm::clamp(color, 0.0F, 1.0F))), 65535};
    }

  private:
    [[nodiscard]] glm::vec3 triple(const std::vector<float>& values, int index, const char* what) const {
        const auto i = static_cast<std::size_t>(index);
        if (index < 0 || 3 * i + 2 >= values.size()) {
            throw Error(fmt::format("a face names {} {}, but there are {}", what, index + 1, values.size() / 3),
                        path_.string(), "Export the model again.");
        }
        return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    }

    const tinyobj::attrib_t& attributes_;
    const fs::path& path_;
};

}  // namespace

Scene load_obj(const fs::path& path) {
    if (!std::ifstream(path)) throw Error("cannot be read", path.string());
    tinyobj::ObjReader reader;
    if (!reader.ParseFromFile(path.string())) {
        throw Error(reader.Error().empty() ? "is no OBJ file" : reader.Error(), path.string());
    }
    Scene scene;
    scene.name = path.filename().string();
    note_lines(reader.Warning(), scene);
    Pictures pictures(path.parent_path(), scene);
    for (const tinyobj::material_t& material : reader.GetMaterials()) {
        scene.materials.push_back(material_of(material, pictures));
    }
    // What names no material is white.
    const int plain = static_cast<int>(scene.materials.size());
    scene.materials.emplace_back();

    std::vector<Mesh> meshes(scene.materials.size());
    const Corners corners(reader.GetAttrib(), path);
    for (const tinyobj::shape_t& shape : reader.GetShapes()) {
        for (std::size_t face = 0; 3 * face + 2 < shape.mesh.indices.size(); ++face) {
            const tinyobj::index_t* const indices = &shape.mesh.indices[3 * face];
            const std::array p{corners.position(indices[0]), corners.position(indices[1]),
                               corners.position(indices[2])};
            if (!has_area(p[0], p[1], p[2])) continue;
            const int named = face < shape.mesh.material_ids.size() ? shape.mesh.material_ids[face] : -1;
            const int material = named < 0 || named >= plain ? plain : named;
            Mesh& mesh = meshes[static_cast<std::size_t>(material)];
            mesh.material = material;
            mesh.uv_sets.resize(1);
            const auto first = static_cast<std::uint32_t>(mesh.positions.size());
            mesh.triangles.emplace_back(first, first + 1, first + 2);
            for (std::size_t k = 0; k < 3; ++k) {
                scene.bounds.extend(p[k]);
                mesh.positions.push_back(p[k]);
                mesh.uv_sets[0].push_back(corners.uv(indices[k]));
                mesh.colors.push_back(corners.color(indices[k]));
            }
        }
    }
    for (Mesh& mesh : meshes) {
        if (mesh.triangles.empty()) continue;
        mesh.positions.reserve(mesh.positions.size() + 1);
        scene.placed.push_back(static_cast<int>(scene.meshes.size()));
        scene.meshes.push_back(std::move(mesh));
    }
    if (scene.meshes.empty()) throw Error("no triangle with an area", path.string(), "Is it an OBJ file?");
    return scene;
}

}  // namespace lightgrid
