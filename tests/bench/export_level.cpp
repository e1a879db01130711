// bench_export_level LEVEL FOLDER
//
// Writes a level as a Mitsuba 3 scene, FOLDER/scene.xml with its meshes and textures beside it, so that another
// renderer traces the very triangles that the tracer does. Coordinates are the level's own.

#include "core/error.h"
#include "core/gltf.h"
#include "core/tracer.h"
#include "core/whole_file.h"
#include "tools/program.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <filesystem>
#include <string>
#include <vector>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "the .ply files say that they are little-endian");

/// Bytes of a binary .ply file.
class Bytes {
  public:
    explicit Bytes(std::string header) : bytes_(std::move(header)) {}
    template <typename T>
    void add(const T& value) {
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
    }
    [[nodiscard]] const std::string& all() const { return bytes_; }

  private:
    std::string bytes_;
};

/// The mesh where one of its instances (or it alone) stands, moved by `shift` along its vertex normals. `turned` shows
/// its back.
std::string ply(const Scene& scene, const Mesh& mesh, const Instance* instance, bool turned, double shift) {
    std::vector<glm::dvec3> positions;
    for (const glm::vec3& local : mesh.positions)
        positions.push_back(instance == nullptr ? glm::dvec3(local)
                                                : glm::dmat4x3(instance->to_level) * glm::dvec4(local, 1));
    std::vector<glm::uvec3> triangles = mesh.triangles;
    if (turned != (instance != nullptr && instance->mirrored))
        for (glm::uvec3& triangle : triangles) std::swap(triangle.y, triangle.z);
    std::vector<glm::dvec3> normals(positions.size(), glm::dvec3(0));
    for (const glm::uvec3& t : triangles)
        for (int k = 0; k < 3; ++k)
            normals[t[k]] += glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);

    const TextureUse& use = scene.materials[static_cast<std::size_t>(mesh.material)].base_color_texture;
    Bytes bytes(fmt::format(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
        "property float z\n{}{}element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        positions.size(), use.used() ? "property float u\nproperty float v\n" : "",
        mesh.colors.empty() ? "" : "property float r\nproperty float g\nproperty float b\n", triangles.size()));
    for (std::size_t i = 0; i < positions.size(); ++i) {
        bytes.add(
            glm::vec3(positions[i] + scene.origin + (shift == 0 ? glm::dvec3(0) : glm::normalize(normals[i]) * shift)));
        if (use.used()) bytes.add(use.transform * glm::vec3(mesh.uv_sets[static_cast<std::size_t>(use.uv_set)][i], 1));
        if (!mesh.colors.empty()) bytes.add(glm::vec3(mesh.colors[i]) * (1.0F / 65535));
    }
    for (const glm::uvec3& triangle : triangles) {
        bytes.add(std::uint8_t{3});
        bytes.add(triangle);
    }
    return bytes.all();
}

std::string rgb(const char* name, glm::vec3 v) {
    return fmt::format("<rgb name=\"{}\" value=\"{} {} {}\"/>", name, v.r, v.g, v.b);
}

/// Albedo as a texture or colour of Mitsuba's, textures times the material's factor.
std::string reflectance(const Scene& scene, std::size_t index, const Mesh& mesh, const fs::path& folder) {
    const Material& material = scene.materials[index];
    if (!material.base_color_texture.used()) {
        if (mesh.colors.empty()) return rgb("reflectance", glm::min(material.base_color, max_albedo));
        if (material.base_color != glm::vec3(1)) throw Error("has vertex colours and a factor", material.name);
        return "<texture type=\"mesh_attribute\" name=\"reflectance\"><string name=\"name\" "
               "value=\"vertex_color\"/></texture>";
    }
    if (!mesh.colors.empty()) throw Error("has vertex colours and a texture", material.name);
    const Texture& texture = scene.textures[static_cast<std::size_t>(material.base_color_texture.texture)];
    if (texture.wrap_u != texture.wrap_v) throw Error("its texture wraps differently in u and v", material.name);
    RadianceImage image{texture.image.width, texture.image.height, {}};
    for (const glm::u8vec4& texel : texture.image.pixels)
        image.pixels.push_back(
            glm::min(material.base_color * glm::vec3(decode_srgb(texel.r), decode_srgb(texel.g), decode_srgb(texel.b)),
                     max_albedo));
    const std::string file = fmt::format("texture{}.exr", index);
    write_exr(image, folder / file);
    constexpr std::array wraps = {"repeat", "mirror", "clamp"};
    return fmt::format(
        "<texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"{}\"/>"
        "<boolean name=\"raw\" value=\"true\"/><string name=\"wrap_mode\" value=\"{}\"/>"
        "<string name=\"filter_type\" value=\"{}\"/></texture>",
        file, wraps[static_cast<std::size_t>(texture.wrap_u)], texture.nearest ? "nearest" : "bilinear");
}

class Exporter {
  public:
    Exporter(const Scene& scene, fs::path folder)
        : scene_(scene), folder_(std::move(folder)), shift_(1e-6 * glm::length(scene.bounds.size())) {}

    void run() {
        if (!scene_.lights.empty()) throw Error("has punctual lights, which are not exported", scene_.name);
        for (const int mesh : scene_.placed) add(scene_.meshes[static_cast<std::size_t>(mesh)], nullptr);
        for (const Instance& instance : scene_.instances)
            for (const int mesh : scene_.models[static_cast<std::size_t>(instance.model)].meshes)
                add(scene_.meshes[static_cast<std::size_t>(mesh)], &instance);
        write_whole_file(folder_ / "scene.xml", "<scene version=\"3.0.0\">\n" + xml_ + "</scene>\n");
    }

  private:
    void add(const Mesh& mesh, const Instance* instance) {
        const Material& material = scene_.materials[static_cast<std::size_t>(mesh.material)];
        if (material.transmission == 1 && material.base_color == glm::vec3(1)) return;  // passes all light
        if (material.passes_light() || material.emission_texture.used())
            throw Error("lets light pass, or its emission has a texture: not exported", material.name);
        if (!material.emits() || !material.double_sided) return add(mesh, instance, false, 0);
        // Mitsuba's emitters have one side: two of them, back to back.
        add(mesh, instance, false, shift_);
        add(mesh, instance, true, shift_);
    }

    void add(const Mesh& mesh, const Instance* instance, bool turned, double shift) {
        const auto index = static_cast<std::size_t>(mesh.material);
        const Material& material = scene_.materials[index];
        const std::string file = fmt::format("mesh{}.ply", count_++);
        write_whole_file(folder_ / file, ply(scene_, mesh, instance, turned, shift));
        xml_ += fmt::format(
            "<shape type=\"ply\"><string name=\"filename\" value=\"{}\"/><boolean name=\"face_normals\" "
            "value=\"true\"/>"
            "<bsdf type=\"twosided\"><bsdf type=\"diffuse\">{}</bsdf></bsdf>{}</shape>\n",
            file, reflectance(scene_, index, mesh, folder_),
            material.emits() ? "<emitter type=\"area\">" + rgb("radiance", material.emission) + "</emitter>" : "");
    }

    const Scene& scene_;
    fs::path folder_;
    double shift_;  // metres
    std::string xml_;
    int count_ = 0;
};

int run(int argc, char** argv) {
    if (argc != 3) throw Error("call it with LEVEL and FOLDER");
    fs::create_directories(argv[2]);
    const Scene scene = load_level(argv[1]);
    Exporter(scene, argv[2]).run();
    return 0;
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    return lightgrid::run_program("bench_export_level", [&] { return lightgrid::run(argc, argv); });
}
