#include "core/scene.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lightgrid {
namespace {

/// decode_srgb for every 8-bit value, where the look-ups below can inline it.
const std::array<float, 256> srgb_to_linear = [] {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) table[i] = decode_srgb(static_cast<std::uint8_t>(i));
    return table;
}();

/// The two texels around a coordinate along one axis, and the weight of the second.
struct Tap {
    int first = 0;
    int second = 0;
    float weight = 0;
};

/// std::floor without the function call that it is where SSE 4.1 is not assumed: a look-up takes 8 % less time.
float floor_of(float value) {
    constexpr float all_whole = 8388608;  // 2^23: from here on there are no fractions
    if (!(std::abs(value) < all_whole)) return value;
    const auto truncated = static_cast<float>(static_cast<int>(value));
    return truncated - static_cast<float>(truncated > value);
}

/// Brings a texture coordinate into [0, 1]; whatever is not a number becomes 0.
float wrapped(float coordinate, Wrap wrap) {
    switch (wrap) {
        case Wrap::repeat:
            coordinate -= floor_of(coordinate);
            break;
        case Wrap::mirror:
            coordinate -= 2 * floor_of(0.5F * coordinate);
            if (coordinate > 1) coordinate = 2 - coordinate;
            break;
        case Wrap::clamp:
            break;
    }
    return coordinate > 0 ? std::min(coordinate, 1.0F) : 0.0F;
}

Tap tap(float coordinate, int size, Wrap wrap, bool nearest) {
    const float position = wrapped(coordinate, wrap) * static_cast<float>(size);
    if (nearest) {
        const int texel = std::min(static_cast<int>(position), size - 1);
        return {texel, texel, 0};
    }
    const float centred = position - 0.5F;
    const float below = floor_of(centred);
    Tap result{static_cast<int>(below), static_cast<int>(below) + 1, centred - below};
    // Beyond the edge lies the other side if the texture repeats, else (clamped or mirrored) the edge itself.
    const bool repeats = wrap == Wrap::repeat;
    if (result.first < 0) result.first = repeats ? size - 1 : 0;
    if (result.second >= size) result.second = repeats ? 0 : size - 1;
    return result;
}

/// Bilinear (or nearest) look-up of whatever `decode` makes of a texel.
template <typename Decode>
auto look_up(const Texture& texture, glm::vec2 uv, Decode decode) {
    const ByteImage& image = texture.image;
    const Tap x = tap(uv.x, image.width, texture.wrap_u, texture.nearest);
    const Tap y = tap(uv.y, image.height, texture.wrap_v, texture.nearest);
    const auto row = [&](int line) {
        const auto left = decode(image.at(x.first, line));
        return left + (decode(image.at(x.second, line)) - left) * x.weight;
    };
    const auto top = row(y.first);
    return top + (row(y.second) - top) * y.weight;
}

glm::vec4 srgb_texel(glm::u8vec4 texel) {
    return {srgb_to_linear[texel.r], srgb_to_linear[texel.g], srgb_to_linear[texel.b],
            static_cast<float>(texel.a) * (1.0F / 255)};
}
glm::vec3 srgb_color_texel(glm::u8vec4 texel) {
    return {srgb_to_linear[texel.r], srgb_to_linear[texel.g], srgb_to_linear[texel.b]};
}
float red_texel(glm::u8vec4 texel) {
    return static_cast<float>(texel.r) * (1.0F / 255);
}
float alpha_texel(glm::u8vec4 texel) {
    return static_cast<float>(texel.a) * (1.0F / 255);
}

/// A place on a triangle: reads what is stored at its vertices.
struct Place {
    const Mesh& mesh;
    glm::uvec3 vertices;
    glm::vec3 weights;

    Place(const Mesh& of, std::uint32_t triangle, glm::vec2 barycentric)
        : mesh(of),
          vertices(of.triangles[triangle]),
          weights(1 - barycentric.x - barycentric.y, barycentric.x, barycentric.y) {}

    [[nodiscard]] glm::vec2 uv(const TextureUse& use) const {
        const std::vector<glm::vec2>& set = mesh.uv_sets[static_cast<std::size_t>(use.uv_set)];
        const glm::vec2 plain =
            weights[0] * set[vertices[0]] + weights[1] * set[vertices[1]] + weights[2] * set[vertices[2]];
        return use.transform * glm::vec3(plain, 1);
    }
    [[nodiscard]] glm::vec4 color() const {
        const std::vector<glm::u16vec4>& colors = mesh.colors;
        return (weights[0] * glm::vec4(colors[vertices[0]]) + weights[1] * glm::vec4(colors[vertices[1]]) +
                weights[2] * glm::vec4(colors[vertices[2]])) *
               (1.0F / 65535);
    }
};

const Texture& texture_of(const Scene& scene, const TextureUse& use) {
    return scene.textures[static_cast<std::size_t>(use.texture)];
}

const Material& material_of(const Scene& scene, const Mesh& mesh) {
    return scene.materials[static_cast<std::size_t>(mesh.material)];
}

/// What the alpha mode makes of factor x texture x vertex alpha.
float opacity(const Material& material, float alpha) {
    if (material.alpha_mode == AlphaMode::mask) return alpha >= material.alpha_cutoff ? 1.0F : 0.0F;
    return glm::clamp(alpha, 0.0F, 1.0F);
}

}  // namespace

float linear_from_srgb(std::uint8_t encoded) noexcept {
    return srgb_to_linear[encoded];
}

bool is_flat(const glm::dmat3& axes) noexcept {
    constexpr double most = 1e9;
    const glm::dmat3 inverse = glm::inverse(axes);
    for (int column = 0; column < 3; ++column) {
        for (int row = 0; row < 3; ++row) {
            if (!(std::abs(inverse[column][row]) <= most)) return true;
        }
    }
    return false;
}

SurfacePoint surface_at(const Scene& scene, const Mesh& mesh, std::uint32_t triangle, glm::vec2 barycentric) noexcept {
    const Material& material = material_of(scene, mesh);
    const Place place(mesh, triangle, barycentric);

    glm::vec4 base(material.base_color, material.alpha);
    if (!mesh.colors.empty()) base *= place.color();
    if (const TextureUse& use = material.base_color_texture; use.used())
        base *= look_up(texture_of(scene, use), place.uv(use), srgb_texel);

    SurfacePoint point;
    point.tint = glm::clamp(glm::vec3(base), 0.0F, 1.0F);
    point.albedo = glm::min(point.tint, max_albedo);
    if (material.alpha_mode != AlphaMode::opaque) point.alpha = opacity(material, base.a);
    point.transmission = material.transmission;
    if (const TextureUse& use = material.transmission_texture; use.used())
        point.transmission *= look_up(texture_of(scene, use), place.uv(use), red_texel);
    point.emission = material.emission;
    if (const TextureUse& use = material.emission_texture; use.used())
        point.emission *= look_up(texture_of(scene, use), place.uv(use), srgb_color_texel);
    return point;
}

float alpha_at(const Scene& scene, const Mesh& mesh, std::uint32_t triangle, glm::vec2 barycentric) noexcept {
    const Material& material = material_of(scene, mesh);
    if (material.alpha_mode == AlphaMode::opaque) return 1;
    const Place place(mesh, triangle, barycentric);
    float alpha = material.alpha;
    if (!mesh.colors.empty()) alpha *= place.color().a;
    if (const TextureUse& use = material.base_color_texture; use.used())
        alpha *= look_up(texture_of(scene, use), place.uv(use), alpha_texel);
    return opacity(material, alpha);
}

}  // namespace lightgrid
