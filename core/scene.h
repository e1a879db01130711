#pragma once

#include "core/image.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

/// The level as plain data: what light needs to know of it and nothing else. Lengths are in the file's units: metres, as
/// glTF says, but for Scene::metres_per_unit. Axes are glTF's (+Y up).
namespace lightgrid {

struct Box {
    glm::dvec3 min{std::numeric_limits<double>::infinity()};
    glm::dvec3 max{-std::numeric_limits<double>::infinity()};

    [[nodiscard]] bool empty() const { return min.x > max.x || min.y > max.y || min.z > max.z; }
    [[nodiscard]] glm::dvec3 size() const { return empty() ? glm::dvec3(0) : max - min; }
    [[nodiscard]] glm::dvec3 center() const { return 0.5 * (min + max); }
    void extend(glm::dvec3 point) {
        min = glm::min(min, point);
        max = glm::max(max, point);
    }
};

enum class Wrap : std::uint8_t { repeat, mirror, clamp };

struct Texture {
    ByteImage image;
    Wrap wrap_u = Wrap::repeat;
    Wrap wrap_v = Wrap::repeat;
    bool nearest = false;
};

/// A use of a texture: which one, read through which UV set, transformed how (KHR_texture_transform).
struct TextureUse {
    int texture = -1;                         // index in Scene::textures; -1: none
    int uv_set = 0;                           // index in Mesh::uv_sets
    glm::mat3x2 transform{1, 0, 0, 1, 0, 0};  // uv' = transform * (u, v, 1)

    [[nodiscard]] bool used() const { return texture >= 0; }
};

enum class AlphaMode : std::uint8_t { opaque, mask, blend };

/// Lambertian on both sides. Colours are linear Rec.709.
struct Material {
    std::string name;
    glm::vec3 base_color{1};  // factor; times texture and vertex colour it is the albedo, clamped to [0, max_albedo]
    TextureUse base_color_texture;  // sRGB; its alpha channel is the material's
    AlphaMode alpha_mode = AlphaMode::opaque;
    float alpha = 1;  // factor
    float alpha_cutoff = 0.5F;
    float transmission = 0;  // KHR_materials_transmission: share that passes straight on, tinted by base colour
    TextureUse transmission_texture;  // linear, red channel
    glm::vec3 emission{0};            // radiance, cd/m^2, factor and strength together
    TextureUse emission_texture;      // sRGB
    bool double_sided = false;        // emits from both sides
    int group = -1;                   // of what it emits: index in Scene::groups; -1: none

    [[nodiscard]] bool emits() const { return emission != glm::vec3(0); }
    /// Light may pass through: MASK, BLEND or transmission.
    [[nodiscard]] bool passes_light() const { return alpha_mode != AlphaMode::opaque || transmission > 0; }
};

inline constexpr float max_albedo = 0.9999F;

/// The triangles of one glTF primitive. The front side is counter-clockwise.
/// Invariant: positions.capacity() > positions.size(), because Embree reads 16 bytes at the last 12-byte vertex.
struct Mesh {
    std::string name;
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
    std::vector<std::vector<glm::vec2>> uv_sets;  // by glTF set number; all that its material reads, others are empty
    std::vector<glm::u16vec4> colors;             // COLOR_0, linear, 65535 = 1; empty where there is none
    int material = 0;                             // index in Scene::materials
    int node = -1;  // that it stands at, where it is placed: index in Scene::node_names; -1: not known
};

/// Meshes that are used several times, in their own space.
struct Model {
    std::vector<int> meshes;
};

struct Instance {
    int model = 0;
    glm::mat4x3 to_level{1};  // columns: axes, then translation relative to Scene::origin; not is_flat
    bool mirrored = false;    // negative determinant: counter-clockwise in the model is clockwise in the level
    int node = -1;            // that it stands at: index in Scene::node_names; -1: not known
};

/// Squeezed so much along some axis (to less than 1e-9) that rays in an instance's own space would leave the range of
/// float; Embree aborts on them. What is flat has to stand in the level itself.
[[nodiscard]] bool is_flat(const glm::dmat3& axes) noexcept;

enum class LightKind : std::uint8_t { directional, point, spot };

/// KHR_lights_punctual. intensity: lux for directional, cd for point and spot.
/// Range window: max(min(1 - (d / range)^4, 1), 0) / d^2. Cone: clamp((cos - cos_outer) / max(0.001, cos_inner -
/// cos_outer))^2.
struct Light {
    std::string name;
    LightKind kind = LightKind::point;
    glm::vec3 intensity{0};
    glm::vec3 position{0};          // relative to Scene::origin
    glm::vec3 direction{0, 0, -1};  // the way the light travels, unit length
    float range = std::numeric_limits<float>::infinity();
    float cos_inner = 1;
    float cos_outer = 0.70710678F;
    int group = -1;  // index in Scene::groups; -1: none
};

/// A decision not to load, trace or store something, and why.
struct LeftOut {
    std::string what;
    std::string evidence;
    std::string saved;
};

struct Scene {
    std::string name;            // file name, for messages
    double metres_per_unit = 1;  // of lengths below; only what is told or chosen in metres heeds it
    glm::dvec3 origin{0};        // the level's position of (0, 0, 0) in everything below: the centre of its bounds
    Box bounds;                  // in the level's own coordinates
    std::vector<Mesh> meshes;
    std::vector<int> placed;  // meshes that stand in the level once, transformed already
    std::vector<Model> models;
    std::vector<Instance> instances;
    std::vector<Material> materials;  // at least one
    std::vector<Texture> textures;
    std::vector<Light> lights;
    std::vector<std::string> groups;        // of lights: node extras {"lightgrid": {"group": "NAME"}}, in order of use
    std::vector<Box> volume_markers;        // node extras {"lightgrid": "volume"}, level coordinates
    std::vector<glm::dvec3> probe_markers;  // node extras {"lightgrid": "probe"}, level coordinates
    std::vector<std::string> node_names;    // what LoadOptions::ignore is tried on; empty: nameless
    std::vector<std::string> missing_textures;  // that light would read, but that cannot be read: the light is not the
                                                // level's own
    std::vector<std::string> notices;           // for the user: what was ignored, clamped or repaired, by name
    std::vector<LeftOut> left_out;
};

/// What a light path reads at a point of a surface.
struct SurfacePoint {
    glm::vec3 albedo{0};  // base colour in [0, max_albedo]
    glm::vec3 tint{1};    // base colour, unclamped above by max_albedo: what transmission is multiplied by, in [0, 1]
    float alpha = 1;      // BLEND opacity; MASK has been decided already: 0 or 1
    float transmission = 0;  // share of the opaque part that passes straight on
    glm::vec3 emission{0};   // radiance from an emitting side, not yet times alpha
};

/// Interpolates and looks up everything at barycentric coordinates (b1, b2) of a triangle: weights 1 - b1 - b2, b1, b2.
[[nodiscard]] SurfacePoint surface_at(const Scene& scene, const Mesh& mesh, std::uint32_t triangle,
                                      glm::vec2 barycentric) noexcept;
/// Only the alpha of it (after the cut-off for MASK), for shadow and alpha tests.
[[nodiscard]] float alpha_at(const Scene& scene, const Mesh& mesh, std::uint32_t triangle,
                             glm::vec2 barycentric) noexcept;

}  // namespace lightgrid
