#include "scenes/glb.h"

#include <stb_image_write.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>

namespace lightgrid::scenes {
namespace {

using Json = nlohmann::ordered_json;

constexpr int float_component = 5126;
constexpr int uint16_component = 5123;
constexpr int uint32_component = 5125;
constexpr int array_buffer = 34962;
constexpr int element_array_buffer = 34963;
constexpr int no_target = 0;

Json to_json(glm::vec2 v) {
    return Json::array({v.x, v.y});
}
Json to_json(glm::vec3 v) {
    return Json::array({v.x, v.y, v.z});
}
Json to_json(glm::quat q) {
    return Json::array({q.x, q.y, q.z, q.w});
}

Json node_of(const std::string& name, const Placement& placement) {
    Json node{{"name", name}};
    if (placement.translation != glm::vec3(0)) node["translation"] = to_json(placement.translation);
    if (placement.rotation != glm::quat(1, 0, 0, 0)) node["rotation"] = to_json(placement.rotation);
    if (placement.scale != glm::vec3(1)) node["scale"] = to_json(placement.scale);
    return node;
}

void append_png(void* bytes, void* data, int size) {
    const auto* begin = static_cast<const std::byte*>(data);
    static_cast<std::vector<std::byte>*>(bytes)->insert(static_cast<std::vector<std::byte>*>(bytes)->end(), begin,
                                                        begin + size);
}

}  // namespace

Glb::Glb() {
    gltf_["asset"] = {{"version", "2.0"}, {"generator", "make_scenes"}};
    gltf_["scene"] = 0;
    gltf_["scenes"] = Json::array({{{"nodes", Json::array()}}});
}

void Glb::use_extension(const std::string& name) {
    auto& used = gltf_["extensionsUsed"];
    for (const auto& extension : used) {
        if (extension == name) return;
    }
    used.push_back(name);
}

int Glb::add_view(std::span<const std::byte> bytes, int target) {
    buffer_.resize((buffer_.size() + 3) / 4 * 4);
    Json view{{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes.size()}};
    if (target != no_target) view["target"] = target;
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
    gltf_["bufferViews"].push_back(view);
    return static_cast<int>(gltf_["bufferViews"].size()) - 1;
}

template <typename T>
int Glb::add_accessor(const std::vector<T>& values, const char* type, int component_type, int target) {
    gltf_["accessors"].push_back({{"bufferView", add_view(std::as_bytes(std::span(values)), target)},
                                  {"componentType", component_type},
                                  {"count", values.size()},
                                  {"type", type}});
    return static_cast<int>(gltf_["accessors"].size()) - 1;
}

int Glb::add_picture(const Picture& picture, const std::string& name) {
    const bool cut_out = std::any_of(picture.pixels.begin(), picture.pixels.end(), [](auto p) { return p.a < 255; });
    const int channels = cut_out ? 4 : 3;
    std::vector<std::uint8_t> bytes;
    for (const glm::u8vec4& pixel : picture.pixels) {
        for (int channel = 0; channel < channels; ++channel) bytes.push_back(pixel[channel]);
    }
    std::vector<std::byte> png;
    if (stbi_write_png_to_func(append_png, &png, picture.width, picture.height, channels, bytes.data(),
                               picture.width * channels) == 0) {
        throw std::runtime_error("cannot encode the picture " + name);
    }
    gltf_["images"].push_back({{"name", name}, {"mimeType", "image/png"}, {"bufferView", add_view(png, no_target)}});
    if (!gltf_.contains("samplers")) gltf_["samplers"].push_back({{"magFilter", 9729}, {"minFilter", 9987}});
    gltf_["textures"].push_back({{"source", gltf_["images"].size() - 1}, {"sampler", 0}});
    return static_cast<int>(gltf_["textures"].size()) - 1;
}

int Glb::add_material(const Material& material) {
    const glm::vec3 color = material.color;
    Json surface{{"baseColorFactor", {color.r, color.g, color.b, material.alpha}},
                 {"metallicFactor", 0},
                 {"roughnessFactor", 1}};
    if (material.picture >= 0) {
        surface["baseColorTexture"] = {{"index", material.picture}};
        if (material.picture_size != glm::vec2(1)) {
            use_extension("KHR_texture_transform");
            surface["baseColorTexture"]["extensions"]["KHR_texture_transform"]["scale"] =
                to_json(1.0F / material.picture_size);
        }
    }
    Json out{{"name", material.name}, {"pbrMetallicRoughness", surface}};
    if (material.alpha < 1) out["alphaMode"] = "BLEND";
    if (material.mask) out["alphaMode"] = "MASK";
    if (material.emission != glm::vec3(0)) {
        // The factor stays within [0, 1], as the specification asks; the strength carries the unit.
        const float strength = std::max({material.emission.r, material.emission.g, material.emission.b, 1.0F});
        out["emissiveFactor"] = to_json(material.emission / strength);
        if (strength > 1) {
            use_extension("KHR_materials_emissive_strength");
            out["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = strength;
        }
    }
    if (material.transmission > 0) {
        use_extension("KHR_materials_transmission");
        out["extensions"]["KHR_materials_transmission"]["transmissionFactor"] = material.transmission;
    }
    gltf_["materials"].push_back(out);
    return static_cast<int>(gltf_["materials"].size()) - 1;
}

int Glb::add_mesh(const Shape& shape, const std::string& name) {
    Json primitives = Json::array();
    for (const auto& [material, surface] : shape) {
        glm::vec3 low(std::numeric_limits<float>::infinity());
        glm::vec3 high(-std::numeric_limits<float>::infinity());
        for (const glm::vec3& position : surface.positions) {
            low = glm::min(low, position);
            high = glm::max(high, position);
        }
        Json attributes;
        attributes["POSITION"] = add_accessor(surface.positions, "VEC3", float_component, array_buffer);
        gltf_["accessors"].back()["min"] = to_json(low);
        gltf_["accessors"].back()["max"] = to_json(high);
        attributes["NORMAL"] = add_accessor(surface.normals, "VEC3", float_component, array_buffer);
        if (gltf_["materials"][material]["pbrMetallicRoughness"].contains("baseColorTexture")) {
            attributes["TEXCOORD_0"] = add_accessor(surface.uvs, "VEC2", float_component, array_buffer);
        }
        int indices = 0;
        if (surface.positions.size() < 65535) {
            const std::vector<std::uint16_t> narrow(surface.indices.begin(), surface.indices.end());
            indices = add_accessor(narrow, "SCALAR", uint16_component, element_array_buffer);
        } else {
            indices = add_accessor(surface.indices, "SCALAR", uint32_component, element_array_buffer);
        }
        primitives.push_back({{"attributes", attributes}, {"indices", indices}, {"material", material}});
    }
    gltf_["meshes"].push_back({{"name", name}, {"primitives", primitives}});
    return static_cast<int>(gltf_["meshes"].size()) - 1;
}

void Glb::add_node(Json node) {
    gltf_["nodes"].push_back(std::move(node));
    gltf_["scenes"][0]["nodes"].push_back(gltf_["nodes"].size() - 1);
}

void Glb::place(int mesh, const std::string& name, const Placement& placement) {
    Json node = node_of(name, placement);
    node["mesh"] = mesh;
    add_node(std::move(node));
}

void Glb::place_instances(int mesh, const std::string& name, std::span<const Placement> placements) {
    std::vector<glm::vec3> translations;
    std::vector<glm::vec4> rotations;
    std::vector<glm::vec3> scales;
    for (const Placement& placement : placements) {
        translations.push_back(placement.translation);
        rotations.emplace_back(placement.rotation.x, placement.rotation.y, placement.rotation.z, placement.rotation.w);
        scales.push_back(placement.scale);
    }
    use_extension("EXT_mesh_gpu_instancing");
    Json node{{"name", name}, {"mesh", mesh}};
    node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", add_accessor(translations, "VEC3", float_component, no_target)},
        {"ROTATION", add_accessor(rotations, "VEC4", float_component, no_target)},
        {"SCALE", add_accessor(scales, "VEC3", float_component, no_target)}};
    add_node(std::move(node));
}

void Glb::place_light(const Light& light, const Placement& placement) {
    use_extension("KHR_lights_punctual");
    Json out{
        {"name", light.name}, {"type", light.type}, {"intensity", light.intensity}, {"color", to_json(light.color)}};
    if (light.range < std::numeric_limits<float>::infinity()) out["range"] = light.range;
    if (light.type == "spot") {
        out["spot"] = {{"innerConeAngle", light.inner_cone}, {"outerConeAngle", light.outer_cone}};
    }
    auto& lights = gltf_["extensions"]["KHR_lights_punctual"]["lights"];
    lights.push_back(out);
    Json node = node_of(light.name, placement);
    node["extensions"]["KHR_lights_punctual"]["light"] = lights.size() - 1;
    add_node(std::move(node));
}

void Glb::group(std::size_t count, const std::string& name) {
    auto& roots = gltf_["scenes"][0]["nodes"];
    const auto first = roots.end() - static_cast<std::ptrdiff_t>(count);
    Json node{{"name", name}, {"children", Json(first, roots.end())}};
    roots.erase(first, roots.end());
    node["extras"]["lightgrid"]["group"] = name;
    add_node(std::move(node));
}

void Glb::mark_volume(glm::vec3 center, glm::vec3 size) {
    Json node = node_of("probes", {center, {1, 0, 0, 0}, size});
    node["extras"] = {{"lightgrid", "volume"}};
    add_node(std::move(node));
}

void Glb::write(const std::filesystem::path& path) const {
    Json gltf = gltf_;
    gltf["buffers"] = Json::array({{{"byteLength", buffer_.size()}}});
    std::string text = gltf.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<std::byte> data = buffer_;
    data.resize((data.size() + 3) / 4 * 4);

    std::ofstream file(path, std::ios::binary);
    const auto write_words = [&](const auto&... words) {
        const std::array<std::uint32_t, sizeof...(words)> all{static_cast<std::uint32_t>(words)...};
        file.write(reinterpret_cast<const char*>(all.data()), sizeof all);
    };
    constexpr std::uint32_t magic = 0x46546C67;  // "glTF"
    constexpr std::uint32_t json_chunk = 0x4E4F534A;
    constexpr std::uint32_t bin_chunk = 0x004E4942;
    write_words(magic, 2, 12 + 8 + text.size() + 8 + data.size(), text.size(), json_chunk);
    file.write(text.data(), static_cast<std::streamsize>(text.size()));
    write_words(data.size(), bin_chunk);
    file.write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size()));
    if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace lightgrid::scenes
