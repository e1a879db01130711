#include "tools/canvas.h"

#include "core/error.h"

#include <stb_easy_font.h>
#include <stb_image_write.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace lightgrid {

glm::vec3 hex_color(unsigned hex) {
    return glm::vec3((hex >> 16) & 255U, (hex >> 8) & 255U, hex & 255U) / 255.0F;
}

Canvas::Canvas(int w, int h, glm::vec3 background)
    : width(w), height(h), pixels(static_cast<std::size_t>(w) * h, background) {}

void Canvas::blend(int x, int y, glm::vec3 color, float opacity) {
    if (x < 0 || y < 0 || x >= width || y >= height) return;
    at(x, y) = glm::mix(at(x, y), color, opacity);
}

void Canvas::fill(glm::ivec2 corner, glm::ivec2 size, glm::vec3 color) {
    for (int y = corner.y; y < corner.y + size.y; ++y) {
        for (int x = corner.x; x < corner.x + size.x; ++x) blend(x, y, color, 1);
    }
}

void Canvas::disc(glm::vec2 center, float radius, glm::vec3 color, glm::vec3 ring, float ring_width) {
    const float reach = radius + ring_width + 1;
    const glm::ivec2 low(glm::floor(center - reach));
    const glm::ivec2 high(glm::ceil(center + reach));
    for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
            const float distance = glm::distance(glm::vec2(x, y) + 0.5F, center);
            blend(x, y, ring, glm::clamp(radius + ring_width + 0.5F - distance, 0.0F, 1.0F));
            blend(x, y, color, glm::clamp(radius + 0.5F - distance, 0.0F, 1.0F));
        }
    }
}

void Canvas::paste(const Canvas& other, glm::ivec2 corner) {
    for (int y = 0; y < other.height; ++y) {
        for (int x = 0; x < other.width; ++x) {
            blend(corner.x + x, corner.y + y, other.pixels[static_cast<std::size_t>(y) * other.width + x], 1);
        }
    }
}

int Canvas::text(glm::ivec2 corner, const std::string& text, glm::vec3 color, int scale) {
    struct Vertex {
        float x, y, z;
        std::uint32_t color;
    };
    std::string copy = text;                         // the font's interface is not const
    std::vector<Vertex> vertices(80 * copy.size());  // twice what its documentation expects
    const int quads = stb_easy_font_print(0, 0, copy.data(), nullptr, vertices.data(),
                                          static_cast<int>(vertices.size() * sizeof(Vertex)));
    for (int quad = 0; quad < quads; ++quad) {
        const Vertex& low = vertices[static_cast<std::size_t>(quad) * 4];
        const Vertex& high = vertices[static_cast<std::size_t>(quad) * 4 + 2];
        const glm::ivec2 from(std::lround(low.x), std::lround(low.y));
        const glm::ivec2 to(std::lround(high.x), std::lround(high.y));
        fill(corner + scale * from, scale * (to - from), color);
    }
    return scale * stb_easy_font_width(copy.data());
}

void Canvas::write_png(const std::filesystem::path& path) const {
    std::vector<std::uint8_t> bytes;
    bytes.reserve(3 * pixels.size());
    for (const glm::vec3& pixel : pixels) {
        const glm::vec3 rounded = glm::round(255.0F * glm::clamp(pixel, 0.0F, 1.0F));
        for (int channel = 0; channel < 3; ++channel) bytes.push_back(static_cast<std::uint8_t>(rounded[channel]));
    }
    if (stbi_write_png(path.string().c_str(), width, height, 3, bytes.data(), width * 3) == 0) {
        throw Error("cannot be written", path.string(), "Check that the folder exists and has room", Fault::work);
    }
}

}  // namespace lightgrid
