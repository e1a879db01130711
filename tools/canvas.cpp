#include "tools/canvas.h"

#include "core/error.h"
#include "core/whole_file.h"
#include "tools/lettering.h"

#include <stb_image_write.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

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

int Canvas::text(glm::ivec2 corner, const std::string& text, glm::vec3 color, float cap_height) {
    const float half_pen = std::max(0.06F * cap_height, 0.6F);
    const Lettering lettering = letter(text, cap_height);
    // Coverage first: strokes that cross must not darken twice.
    const glm::ivec2 size(static_cast<int>(lettering.width) + 4, static_cast<int>(1.5F * cap_height) + 4);
    std::vector<float> cover(static_cast<std::size_t>(size.x) * size.y, 0.0F);
    for (const Stroke& stroke : lettering.strokes) {
        const glm::vec2 along = stroke.to - stroke.from;
        const glm::ivec2 low = glm::max(glm::ivec2(glm::min(stroke.from, stroke.to) - half_pen), glm::ivec2(0));
        const glm::ivec2 high =
            glm::min(glm::ivec2(glm::max(stroke.from, stroke.to) + half_pen + 3.0F), size - glm::ivec2(1));
        for (int y = low.y; y <= high.y; ++y) {
            for (int x = low.x; x <= high.x; ++x) {
                const glm::vec2 from_start = glm::vec2(x, y) + 0.5F - 1.5F - stroke.from;
                const float t = glm::clamp(glm::dot(from_start, along) / glm::dot(along, along), 0.0F, 1.0F);
                const float distance = glm::length(from_start - t * along);
                float& pixel = cover[static_cast<std::size_t>(y) * size.x + x];
                pixel = std::max(pixel, glm::clamp(half_pen + 0.5F - distance, 0.0F, 1.0F));
            }
        }
    }
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
            blend(corner.x + x - 1, corner.y + y - 1, color, cover[static_cast<std::size_t>(y) * size.x + x]);
        }
    }
    return static_cast<int>(lettering.width);
}

std::string Canvas::png() const {
    std::vector<std::uint8_t> bytes;
    bytes.reserve(3 * pixels.size());
    for (const glm::vec3& pixel : pixels) {
        const glm::vec3 rounded = glm::round(255.0F * glm::clamp(pixel, 0.0F, 1.0F));
        for (int channel = 0; channel < 3; ++channel) bytes.push_back(static_cast<std::uint8_t>(rounded[channel]));
    }
    std::string png;
    const auto append = [](void* to, void* data, int size) {
        static_cast<std::string*>(to)->append(static_cast<const char*>(data), static_cast<std::size_t>(size));
    };
    if (stbi_write_png_to_func(append, &png, width, height, 3, bytes.data(), width * 3) == 0) {
        throw Error("a picture does not fit into memory as PNG", {}, "Draw a smaller one", Fault::work);
    }
    return png;
}

void Canvas::write_png(const std::filesystem::path& path) const {
    write_whole_file(path, png());
}

}  // namespace lightgrid
