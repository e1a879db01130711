#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

/// A small writer of binary glTF 2.0, only as wide as the levels need. Independent of the library on purpose: what the
/// levels mean must not depend on the code that they test.
namespace lightgrid::scenes {

/// Eight bits a channel, sRGB, row-major, top row first.
struct Picture {
    int width = 0;
    int height = 0;
    std::vector<glm::u8vec4> pixels;

    Picture(int w, int h) : width(w), height(h), pixels(static_cast<std::size_t>(w) * h) {}
    [[nodiscard]] glm::u8vec4& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

struct Material {
    std::string name;
    glm::vec3 color{0.7F};      // linear Rec.709: the albedo, or its factor where there is a picture
    int picture = -1;           // of Glb::add_picture; -1: none
    glm::vec2 picture_size{1};  // metres that the picture spans: texture coordinates are metres
    glm::vec3 emission{0};      // radiance, cd/m^2, of the front side
    float alpha = 1;            // below 1: BLEND
    bool mask = false;          // alpha of the picture cuts out at one half
    float transmission = 0;     // share that passes straight on, tinted by the colour
};

/// Triangles of one material. Front sides are counter-clockwise. Normals are for viewers that shade smoothly.
struct Surface {
    int material = 0;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<glm::vec2> uvs;  // metres along the surface, v downwards
    std::vector<std::uint32_t> indices;
};

/// One surface per material.
using Shape = std::map<int, Surface>;

struct Placement {
    glm::vec3 translation{0};
    glm::quat rotation{1, 0, 0, 0};
    glm::vec3 scale{1};
};

/// KHR_lights_punctual. Light travels along -Z of the placement. intensity: cd; directional: lux.
struct Light {
    std::string name;
    std::string type;  // "directional", "point" or "spot"
    float intensity = 1;
    glm::vec3 color{1};
    float range = std::numeric_limits<float>::infinity();
    float inner_cone = 0;               // radians, spot only
    float outer_cone = 0.78539816339F;  // radians, spot only
};

/// Collects a level and writes it. Order of calls is order in the file: the same calls give the same bytes.
class Glb {
  public:
    Glb();

    int add_picture(const Picture& picture, const std::string& name);
    int add_material(const Material& material);
    int add_mesh(const Shape& shape, const std::string& name);

    /// A node that shows `mesh`.
    void place(int mesh, const std::string& name, const Placement& placement = {});
    /// One node that shows `mesh` many times (EXT_mesh_gpu_instancing).
    void place_instances(int mesh, const std::string& name, std::span<const Placement> placements);
    void place_light(const Light& light, const Placement& placement);
    /// Puts the last `count` nodes below one that is a group of lights for level-bake.
    void group(std::size_t count, const std::string& name);
    /// A mark for level-bake: put probes into the box of this size around `center` and nowhere else.
    void mark_volume(glm::vec3 center, glm::vec3 size);

    /// Throws std::runtime_error where the file cannot be written.
    void write(const std::filesystem::path& path) const;

  private:
    int add_view(std::span<const std::byte> bytes, int target);
    template <typename T>
    int add_accessor(const std::vector<T>& values, const char* type, int component_type, int target);
    void add_node(nlohmann::ordered_json node);
    void use_extension(const std::string& name);

    nlohmann::ordered_json gltf_;
    std::vector<std::byte> buffer_;
};

}  // namespace lightgrid::scenes
