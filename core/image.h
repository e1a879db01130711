#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace lightgrid {

/// Linear radiance (or any other linear quantity), row-major, top row first.
struct RadianceImage {
    int width = 0;
    int height = 0;
    std::vector<glm::vec3> pixels;

    [[nodiscard]] const glm::vec3& at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
    [[nodiscard]] glm::vec3& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

/// Eight bits a channel as stored in the file (no sRGB decoding), row-major, top row first. Missing alpha is 255; grey is
/// spread over R, G, B.
struct ByteImage {
    int width = 0;
    int height = 0;
    std::vector<glm::u8vec4> pixels;

    [[nodiscard]] const glm::u8vec4& at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

/// PNG, JPEG or WebP from memory, recognised by content; 16-bit PNG is rounded to 8. Throws Error.
[[nodiscard]] ByteImage decode_image(std::span<const std::byte> bytes, const std::string& where);

/// Size in pixels from the header alone: cheap. Throws Error.
[[nodiscard]] glm::ivec2 image_size(std::span<const std::byte> bytes, const std::string& where);

}  // namespace lightgrid
