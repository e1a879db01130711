#include "core/gltf.h"

#include "core/error.h"
#include "core/parallel.h"

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <span>

namespace lightgrid {
namespace {

bool keep_bytes(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes, int size,
                void*) {
    image->image.assign(bytes, bytes + size);
    image->as_is = true;
    return true;
}

tinygltf::Model read_model(const std::filesystem::path& path) {
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(keep_bytes, nullptr);
    tinygltf::Model model;
    std::string error;
    std::string warning;
    std::ifstream file(path, std::ios::binary);
    if (!file) throw Error("cannot be opened", path.string(), "Check the path.");
    char magic[4] = {};
    file.read(magic, 4);
    const bool binary = std::memcmp(magic, "glTF", 4) == 0;
    const bool loaded = binary ? loader.LoadBinaryFromFile(&model, &error, &warning, path.string())
                               : loader.LoadASCIIFromFile(&model, &error, &warning, path.string());
    if (!loaded) throw Error(error.empty() ? "is not glTF" : error, path.string(), "Re-export the level.");
    return model;
}

/// Reads components of an accessor as numbers; normalised integers become [0, 1] or [-1, 1].
class Reader {
  public:
    Reader(const tinygltf::Model& model, int index) {
        if (index < 0 || static_cast<std::size_t>(index) >= model.accessors.size())
            throw Error(fmt::format("accessor {} does not exist", index));
        const tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(index)];
        const std::string where = fmt::format("accessor {}", index);
        if (accessor.sparse.isSparse || accessor.bufferView < 0) throw Error("sparse or compressed data", where);
        if (static_cast<std::size_t>(accessor.bufferView) >= model.bufferViews.size())
            throw Error("bufferView does not exist", where);
        const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
        if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model.buffers.size())
            throw Error("buffer does not exist", where);
        const auto& bytes = model.buffers[static_cast<std::size_t>(view.buffer)].data;
        count = accessor.count;
        components = tinygltf::GetNumComponentsInType(static_cast<unsigned>(accessor.type));
        type_ = accessor.componentType;
        normalized_ = accessor.normalized;
        const int size = tinygltf::GetComponentSizeInBytes(static_cast<unsigned>(type_));
        const int stride = accessor.ByteStride(view);
        if (size <= 0 || components <= 0 || stride <= 0) throw Error("unknown type", where);
        size_ = static_cast<std::size_t>(size);
        stride_ = static_cast<std::size_t>(stride);
        const std::size_t begin = view.byteOffset + accessor.byteOffset;
        if (count > 0 && (count > bytes.size() / stride_ + 1 || begin > bytes.size() ||
                          (count - 1) * stride_ + size_ * static_cast<std::size_t>(components) > bytes.size() - begin))
            throw Error("reaches past the end of its buffer", where, "Re-export the level.");
        data_ = bytes.data() + begin;
    }

    [[nodiscard]] double number(std::size_t element, int component) const {
        const unsigned char* p = data_ + element * stride_ + size_ * static_cast<std::size_t>(component);
        switch (type_) {
            case TINYGLTF_COMPONENT_TYPE_FLOAT:
                return read<float>(p);
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
                return read<std::uint8_t>(p) / (normalized_ ? 255.0 : 1.0);
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
                return read<std::uint16_t>(p) / (normalized_ ? 65535.0 : 1.0);
            case TINYGLTF_COMPONENT_TYPE_BYTE:
                return normalized_ ? std::max(read<std::int8_t>(p) / 127.0, -1.0) : read<std::int8_t>(p);
            case TINYGLTF_COMPONENT_TYPE_SHORT:
                return normalized_ ? std::max(read<std::int16_t>(p) / 32767.0, -1.0) : read<std::int16_t>(p);
            default:
                return read<std::uint32_t>(p);
        }
    }

    std::size_t count = 0;
    int components = 0;

  private:
    template <typename T>
    static T read(const unsigned char* p) {
        T value;
        std::memcpy(&value, p, sizeof(T));
        return value;
    }

    const unsigned char* data_ = nullptr;
    std::size_t size_ = 0;
    std::size_t stride_ = 0;
    int type_ = 0;
    bool normalized_ = false;
};

glm::dmat4 local_transform(const tinygltf::Node& node) {
    if (node.matrix.size() == 16) return glm::make_mat4(node.matrix.data());
    glm::dmat4 result(1);
    if (node.translation.size() == 3) result = glm::translate(result, glm::make_vec3(node.translation.data()));
    if (node.rotation.size() == 4)
        result *= glm::mat4_cast(
            glm::normalize(glm::dquat(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2])));
    if (node.scale.size() == 3) result = glm::scale(result, glm::make_vec3(node.scale.data()));
    return result;
}

struct PlacedNode {
    int node = 0;
    glm::dmat4 to_level{1};
};

void walk(const tinygltf::Model& model, int index, const glm::dmat4& parent, std::size_t depth,
          std::vector<PlacedNode>& nodes) {
    if (index < 0 || static_cast<std::size_t>(index) >= model.nodes.size())
        throw Error(fmt::format("node {} does not exist", index));
    if (depth > model.nodes.size()) throw Error("nodes form a cycle", fmt::format("node {}", index));
    const tinygltf::Node& node = model.nodes[static_cast<std::size_t>(index)];
    const glm::dmat4 to_level = parent * local_transform(node);
    nodes.push_back({index, to_level});
    for (const int child : node.children) walk(model, child, to_level, depth + 1, nodes);
}

int texture_index(const tinygltf::Model& model, int texture, std::map<int, int>& known, std::vector<int>& wanted) {
    if (texture < 0) return -1;
    if (static_cast<std::size_t>(texture) >= model.textures.size()) throw Error("texture does not exist");
    const auto [entry, added] = known.emplace(texture, static_cast<int>(wanted.size()));
    if (added) wanted.push_back(texture);
    return entry->second;
}

Wrap wrap_of(int mode) {
    if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::clamp;
    return mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::mirror : Wrap::repeat;
}

glm::mat3x2 uv_transform(const tinygltf::ExtensionMap& extensions, int& uv_set) {
    const auto found = extensions.find("KHR_texture_transform");
    if (found == extensions.end()) return {1, 0, 0, 1, 0, 0};
    const tinygltf::Value& value = found->second;
    const auto number = [&](const char* key, int i, double fallback) {
        return value.Has(key) ? value.Get(key).Get(i).GetNumberAsDouble() : fallback;
    };
    if (value.Has("texCoord")) uv_set = value.Get("texCoord").GetNumberAsInt();
    const double angle = value.Has("rotation") ? value.Get("rotation").GetNumberAsDouble() : 0;
    const double sx = number("scale", 0, 1);
    const double sy = number("scale", 1, 1);
    return {std::cos(angle) * sx, -std::sin(angle) * sx,  std::sin(angle) * sy,
            std::cos(angle) * sy, number("offset", 0, 0), number("offset", 1, 0)};
}

void load_materials(const tinygltf::Model& model, Scene& scene) {
    std::map<int, int> known;
    std::vector<int> wanted;
    const auto use = [&](const tinygltf::TextureInfo& info) {
        TextureUse result;
        result.texture = texture_index(model, info.index, known, wanted);
        result.uv_set = info.texCoord;
        result.transform = uv_transform(info.extensions, result.uv_set);
        return result;
    };
    for (const tinygltf::Material& source : model.materials) {
        Material material;
        material.name = source.name;
        const auto& base = source.pbrMetallicRoughness.baseColorFactor;
        if (base.size() == 4) {
            material.base_color = glm::clamp(glm::vec3(base[0], base[1], base[2]), 0.0F, 1.0F);
            material.alpha = static_cast<float>(base[3]);
        }
        material.base_color_texture = use(source.pbrMetallicRoughness.baseColorTexture);
        if (source.alphaMode == "MASK") material.alpha_mode = AlphaMode::mask;
        if (source.alphaMode == "BLEND") material.alpha_mode = AlphaMode::blend;
        material.alpha_cutoff = static_cast<float>(source.alphaCutoff);
        material.double_sided = source.doubleSided;
        const auto& emissive = source.emissiveFactor;
        if (emissive.size() == 3) material.emission = glm::vec3(emissive[0], emissive[1], emissive[2]);
        if (const auto strength = source.extensions.find("KHR_materials_emissive_strength");
            strength != source.extensions.end() && strength->second.Has("emissiveStrength"))
            material.emission *= static_cast<float>(strength->second.Get("emissiveStrength").GetNumberAsDouble());
        if (material.emits()) material.emission_texture = use(source.emissiveTexture);
        if (const auto found = source.extensions.find("KHR_materials_transmission");
            found != source.extensions.end() && found->second.Has("transmissionFactor"))
            material.transmission = static_cast<float>(found->second.Get("transmissionFactor").GetNumberAsDouble());
        scene.materials.push_back(std::move(material));
    }
    scene.materials.emplace_back().name = "default";
    scene.textures.resize(wanted.size());
    for_each_index(wanted.size(), [&](std::size_t i) {
        const tinygltf::Texture& source = model.textures[static_cast<std::size_t>(wanted[i])];
        if (source.source < 0 || static_cast<std::size_t>(source.source) >= model.images.size())
            throw Error("texture without an image", fmt::format("texture {}", wanted[i]));
        const auto& bytes = model.images[static_cast<std::size_t>(source.source)].image;
        scene.textures[i].image = decode_image(std::as_bytes(std::span(bytes)), fmt::format("image {}", source.source));
        if (source.sampler >= 0 && static_cast<std::size_t>(source.sampler) < model.samplers.size()) {
            const tinygltf::Sampler& sampler = model.samplers[static_cast<std::size_t>(source.sampler)];
            scene.textures[i].wrap_u = wrap_of(sampler.wrapS);
            scene.textures[i].wrap_v = wrap_of(sampler.wrapT);
            scene.textures[i].nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
        }
    });
}

/// A primitive with vertices transformed into level space (minus `origin`), or as they are.
Mesh load_primitive(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const glm::dmat4& transform,
                    const Scene& scene) {
    Mesh mesh;
    const auto find = [&](const std::string& name) {
        const auto found = primitive.attributes.find(name);
        return found == primitive.attributes.end() ? -1 : found->second;
    };
    const int position = find("POSITION");
    if (position < 0) return mesh;
    const Reader positions(model, position);
    mesh.positions.reserve(positions.count + 1);
    for (std::size_t i = 0; i < positions.count; ++i) {
        const glm::dvec4 p(positions.number(i, 0), positions.number(i, 1), positions.number(i, 2), 1);
        mesh.positions.emplace_back(glm::dvec3(transform * p));
    }
    mesh.material = primitive.material < 0 ? static_cast<int>(scene.materials.size()) - 1 : primitive.material;
    const Material& material = scene.materials.at(static_cast<std::size_t>(mesh.material));
    for (const TextureUse* use :
         {&material.base_color_texture, &material.transmission_texture, &material.emission_texture}) {
        if (!use->used()) continue;
        const auto set = static_cast<std::size_t>(use->uv_set);
        if (mesh.uv_sets.size() <= set) mesh.uv_sets.resize(set + 1);
        if (!mesh.uv_sets[set].empty()) continue;
        mesh.uv_sets[set].resize(mesh.positions.size());
        const int accessor = find(fmt::format("TEXCOORD_{}", set));
        if (accessor < 0) continue;
        const Reader uvs(model, accessor);
        for (std::size_t i = 0; i < std::min(uvs.count, mesh.positions.size()); ++i)
            mesh.uv_sets[set][i] = {uvs.number(i, 0), uvs.number(i, 1)};
    }
    if (const int accessor = find("COLOR_0"); accessor >= 0) {
        const Reader colors(model, accessor);
        mesh.colors.resize(mesh.positions.size(), glm::u16vec4(65535));
        for (std::size_t i = 0; i < std::min(colors.count, mesh.positions.size()); ++i)
            for (int c = 0; c < std::min(colors.components, 4); ++c)
                mesh.colors[i][c] =
                    static_cast<std::uint16_t>(std::lround(65535 * std::clamp(colors.number(i, c), 0.0, 1.0)));
    }
    std::vector<std::uint32_t> indices;
    if (primitive.indices >= 0) {
        const Reader reader(model, primitive.indices);
        indices.resize(reader.count);
        for (std::size_t i = 0; i < reader.count; ++i) {
            indices[i] = static_cast<std::uint32_t>(reader.number(i, 0));
            if (indices[i] >= mesh.positions.size())
                throw Error(fmt::format("index {}, but only {} vertices", indices[i], mesh.positions.size()));
        }
    } else {
        indices.resize(mesh.positions.size());
        for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<std::uint32_t>(i);
    }
    const bool flip = glm::determinant(glm::dmat3(transform)) < 0;
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        glm::uvec3 triangle(indices[i], indices[i + 1], indices[i + 2]);
        if (flip) std::swap(triangle.y, triangle.z);
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

}  // namespace

Scene load_level(const std::filesystem::path& path, const LoadOptions& options) {
    const tinygltf::Model model = read_model(path);
    Scene scene;
    scene.name = path.filename().string();
    load_materials(model, scene);

    int chosen = options.scene >= 0 ? options.scene : std::max(model.defaultScene, 0);
    std::vector<PlacedNode> nodes;
    if (static_cast<std::size_t>(chosen) >= model.scenes.size())
        throw Error(fmt::format("scene {}, but there are {}", chosen, model.scenes.size()), path.string());
    for (const int root : model.scenes[static_cast<std::size_t>(chosen)].nodes)
        walk(model, root, glm::dmat4(1), 0, nodes);

    std::vector<int> uses(model.meshes.size());
    std::vector<Box> bounds(model.meshes.size());
    for (const PlacedNode& placed : nodes) {
        const int index = model.nodes[static_cast<std::size_t>(placed.node)].mesh;
        if (index < 0) continue;
        if (static_cast<std::size_t>(index) >= model.meshes.size()) throw Error("mesh does not exist");
        ++uses[static_cast<std::size_t>(index)];
        for (const tinygltf::Primitive& primitive : model.meshes[static_cast<std::size_t>(index)].primitives) {
            for (const glm::vec3& p : load_primitive(model, primitive, placed.to_level, scene).positions)
                scene.bounds.extend(p);
        }
    }
    if (!scene.bounds.empty()) scene.origin = scene.bounds.center();

    std::map<int, int> models;
    const glm::dmat4 recentre = glm::translate(glm::dmat4(1), -scene.origin);
    for (const PlacedNode& placed : nodes) {
        const tinygltf::Node& node = model.nodes[static_cast<std::size_t>(placed.node)];
        const glm::dmat4 to_level = recentre * placed.to_level;
        if (const auto found = node.extensions.find("KHR_lights_punctual"); found != node.extensions.end()) {
            const int index = found->second.Get("light").GetNumberAsInt();
            const tinygltf::Light& source = model.lights.at(static_cast<std::size_t>(index));
            Light light;
            light.name = source.name.empty() ? node.name : source.name;
            light.kind = source.type == "directional" ? LightKind::directional
                         : source.type == "spot"      ? LightKind::spot
                                                      : LightKind::point;
            light.intensity = glm::vec3(static_cast<float>(source.intensity));
            if (source.color.size() == 3) light.intensity *= glm::vec3(glm::make_vec3(source.color.data()));
            light.position = glm::vec3(to_level[3]);
            light.direction = glm::vec3(glm::normalize(-glm::dvec3(to_level[2])));
            if (source.range > 0) light.range = static_cast<float>(source.range);
            light.cos_inner = static_cast<float>(std::cos(source.spot.innerConeAngle));
            light.cos_outer = static_cast<float>(std::cos(source.spot.outerConeAngle));
            scene.lights.push_back(std::move(light));
        }
        if (node.mesh < 0) continue;
        const bool shared = uses[static_cast<std::size_t>(node.mesh)] > 1;
        const auto [entry, added] = models.emplace(node.mesh, static_cast<int>(scene.models.size()));
        if (shared) {
            scene.instances.push_back(
                {entry->second, glm::mat4x3(to_level), glm::determinant(glm::dmat3(to_level)) < 0});
            if (!added) continue;
            scene.models.emplace_back();
        }
        for (const tinygltf::Primitive& primitive : model.meshes[static_cast<std::size_t>(node.mesh)].primitives) {
            if (primitive.mode != TINYGLTF_MODE_TRIANGLES && primitive.mode != -1) continue;
            Mesh mesh = load_primitive(model, primitive, shared ? glm::dmat4(1) : to_level, scene);
            mesh.name = model.meshes[static_cast<std::size_t>(node.mesh)].name;
            (shared ? scene.models.back().meshes : scene.placed).push_back(static_cast<int>(scene.meshes.size()));
            scene.meshes.push_back(std::move(mesh));
        }
        if (!shared) models.erase(node.mesh);
    }
    return scene;
}

}  // namespace lightgrid
