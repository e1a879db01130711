#include "scenes/pictures.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace lightgrid::scenes {
namespace {

/// A number in [0, 1) that depends on its arguments alone.
float hash(int x, int y, int seed) {
    auto h = static_cast<std::uint32_t>(x) * 0x8DA6B343U ^ static_cast<std::uint32_t>(y) * 0xD8163841U ^
             static_cast<std::uint32_t>(seed) * 0xCB1AB31FU;
    h = (h ^ (h >> 16)) * 0x7FEB352DU;
    h = (h ^ (h >> 15)) * 0x846CA68BU;
    h ^= h >> 16;
    return static_cast<float>(h >> 8) / 16777216.0F;
}

/// Smooth noise in [0, 1) with values at integers, repeating after `period` of them.
float noise(glm::vec2 at, glm::ivec2 period, int seed) {
    const glm::vec2 floor = glm::floor(at);
    const glm::vec2 t = at - floor;
    const glm::vec2 s = t * t * (3.0F - 2.0F * t);
    const auto value = [&](int dx, int dy) {
        const int x = (static_cast<int>(floor.x) + dx) % period.x;
        const int y = (static_cast<int>(floor.y) + dy) % period.y;
        return hash(x, y, seed);
    };
    return glm::mix(glm::mix(value(0, 0), value(1, 0), s.x), glm::mix(value(0, 1), value(1, 1), s.x), s.y);
}

/// Fills a picture from srgb(u, v), (0, 0) the upper left corner, averaged over 2 x 2 samples a pixel.
template <typename Color>
Picture draw(int width, int height, const Color& srgb) {
    Picture picture(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            glm::vec3 sum(0);
            for (int sample = 0; sample < 4; ++sample) {
                const glm::ivec2 place(sample % 2, sample / 2);
                const glm::vec2 offset = 0.25F + 0.5F * glm::vec2(place);
                sum += srgb((glm::vec2(x, y) + offset) / glm::vec2(width, height));
            }
            const glm::vec3 byte = glm::round(255.0F * glm::clamp(0.25F * sum, 0.0F, 1.0F));
            picture.at(x, y) = glm::u8vec4(byte, 255);
        }
    }
    return picture;
}

glm::vec3 rgb(std::uint32_t hex) {
    return glm::vec3((hex >> 16) & 255U, (hex >> 8) & 255U, hex & 255U) / 255.0F;
}

float smooth(float from, float to, float x) {
    return glm::smoothstep(from, to, x);
}

}  // namespace

Picture wood_planks() {
    constexpr int boards = 12;
    constexpr int size = 480;
    return draw(size, size, [](glm::vec2 at) {
        const float across = at.y * boards;
        const int board = static_cast<int>(across);
        const float start = hash(board, 0, 1);  // where this row's first joint is; two boards a row
        const float along = at.x + 1 - start;
        const int length = static_cast<int>(std::floor(along * 2)) % 2;
        const float tone = hash(board, length, 2);
        const float warp = noise({at.x * 6, at.y * boards * 2}, {6, boards * 2}, 3 + board);
        const float grain = noise({at.x * 8 + 0.5F, at.y * 120 + 6 * warp}, {8, 120}, 4);
        const float fine = noise({at.x * 24, at.y * 240}, {24, 240}, 5);
        glm::vec3 color = glm::mix(rgb(0xA87B4F), rgb(0xC49A6C), tone);
        color *= 0.86F + 0.2F * grain + 0.06F * fine;
        const float seam = std::min(across - static_cast<float>(board), static_cast<float>(board) + 1 - across);
        const float joint = std::abs(along * 2 - std::round(along * 2));
        return color * (0.55F + 0.45F * smooth(0.01F, 0.045F, seam)) * (0.6F + 0.4F * smooth(0.001F, 0.004F, joint));
    });
}

Picture checkered_tiles() {
    return draw(160, 160, [](glm::vec2 at) {
        const glm::vec2 tile = at * 2.0F;
        const glm::vec2 within = glm::fract(tile);
        const bool dark = (static_cast<int>(tile.x) + static_cast<int>(tile.y)) % 2 == 1;
        const float edge = std::min({within.x, within.y, 1 - within.x, 1 - within.y});
        const float cloud = noise(at * 10.0F, {10, 10}, 7);
        const glm::vec3 color = (dark ? rgb(0x5F7F82) : rgb(0xE4DED0)) * (0.95F + 0.07F * cloud);
        return glm::mix(rgb(0x9B958A), color, smooth(0.008F, 0.02F, edge));
    });
}

Picture paving() {
    return draw(144, 144, [](glm::vec2 at) {
        const glm::vec2 flag = at * 3.0F;
        const glm::vec2 within = glm::fract(flag);
        const float edge = std::min({within.x, within.y, 1 - within.x, 1 - within.y});
        const float tone = hash(static_cast<int>(flag.x), static_cast<int>(flag.y), 11);
        const float cloud = noise(at * 12.0F, {12, 12}, 12);
        const glm::vec3 color = glm::mix(rgb(0x9A948A), rgb(0xB8AE9E), tone) * (0.92F + 0.12F * cloud);
        return glm::mix(rgb(0x6C7358), color, smooth(0.02F, 0.05F, edge));
    });
}

Picture rug() {
    return draw(288, 192, [](glm::vec2 at) {
        const glm::vec2 inches = at * glm::vec2(36, 24);
        const glm::vec2 stitch = glm::floor(inches * 4.0F) / 4.0F;  // woven: nothing finer than a stitch
        const glm::vec2 from_edge = glm::min(stitch, glm::vec2(35.75F, 23.75F) - stitch);
        const float edge = std::min(from_edge.x, from_edge.y);
        if (edge < 0.75F) return rgb(0xE8DCC4);
        if (edge < 1.5F) return rgb(0x2C3E5C);
        if (edge < 3.25F) {  // zigzag border
            const float run = from_edge.x < from_edge.y ? stitch.y : stitch.x;
            const float zigzag = std::abs(std::fmod(run + 100, 2.0F) - 1);
            return edge - 1.5F < 1.6F * zigzag ? rgb(0xC8553D) : rgb(0xE8DCC4);
        }
        if (edge < 4) return rgb(0x2C3E5C);
        // Diamonds in a row, each of nested bands.
        const float x = std::fmod(stitch.x - 18 + 100 * 7 + 3.5F, 7.0F) - 3.5F;
        const float band = std::abs(x) * 1.1F + std::abs(stitch.y - 12) * 0.62F;
        if (band < 0.9F) return rgb(0xE8DCC4);
        if (band < 1.9F) return rgb(0x2C3E5C);
        if (band < 2.7F) return rgb(0xE0A458);
        if (band < 3.6F) return rgb(0xE8DCC4);
        return std::fmod(band, 1.6F) < 0.3F ? rgb(0xD98A6A) : rgb(0xB5472F);
    });
}

Picture painting() {
    return draw(240, 180, [](glm::vec2 at) {
        glm::vec3 color = glm::mix(rgb(0x3B6A8F), rgb(0xF6C98F), smooth(0, 0.62F, at.y));
        const float sun = glm::distance(at * glm::vec2(4.0F / 3, 1), glm::vec2(0.86F, 0.42F));
        color = glm::mix(rgb(0xF25C3B), color, smooth(0.1F, 0.106F, sun));
        const glm::vec3 hills[] = {rgb(0x7E9AA3), rgb(0x4F7A78), rgb(0x2F5D50), rgb(0x1E3B36)};
        for (int hill = 0; hill < 4; ++hill) {
            const auto index = static_cast<float>(hill);
            const float ridge = 0.52F + 0.12F * index - 0.09F * std::sin(at.x * (5 - index) + 1.9F * index) -
                                0.03F * std::sin(at.x * 13 + 4 * index);
            color = glm::mix(color, hills[hill], smooth(ridge, ridge + 0.006F, at.y));
        }
        return color;
    });
}

Picture print() {
    return draw(120, 160, [](glm::vec2 at) {
        const glm::vec2 p = at * glm::vec2(3, 4);
        glm::vec3 color = rgb(0xEFE7DA);
        const auto disc = [&](glm::vec2 center, float radius, std::uint32_t fill) {
            color = glm::mix(rgb(fill), color, smooth(radius, radius + 0.02F, glm::distance(p, center)));
        };
        disc({1.25F, 1.45F}, 0.8F, 0xD9A441);
        disc({1.85F, 2.35F}, 0.9F, 0x27566B);
        disc({1.1F, 2.75F}, 0.45F, 0xB5472F);
        return color;
    });
}

Picture leaf() {
    constexpr int width = 48;
    constexpr int height = 128;
    Picture picture = draw(width, height, [](glm::vec2 at) {
        const float side = std::abs(at.x - 0.5F);
        const float vein = std::abs(std::fmod(at.y * 9 + side * 5, 1.0F) - 0.5F);
        glm::vec3 color = glm::mix(rgb(0x3F7A3A), rgb(0x6FA050), at.y);
        color *= 1 - 0.12F * smooth(0.42F, 0.5F, vein);
        return glm::mix(rgb(0xA9C47F), color, smooth(0.015F, 0.04F, side));
    });
    for (int y = 0; y < height; ++y) {
        const float up = 1 - (static_cast<float>(y) + 0.5F) / height;  // 0 at the stalk
        const float half = 0.47F * std::pow(std::sin(glm::pi<float>() * std::pow(up, 0.75F)), 0.8F);
        for (int x = 0; x < width; ++x) {
            const float side = std::abs((static_cast<float>(x) + 0.5F) / width - 0.5F);
            const float inside = (std::max(half, 0.02F) - side) * width;  // pixels from the outline
            picture.at(x, y).a = static_cast<std::uint8_t>(std::round(255 * glm::clamp(0.5F + inside, 0.0F, 1.0F)));
        }
    }
    return picture;
}

}  // namespace lightgrid::scenes
