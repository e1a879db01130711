#pragma once

#include <glm/glm.hpp>

#include <filesystem>
#include <string>
#include <vector>

/// A picture to draw on. Colours are sRGB in [0, 1]; positions are pixels, (0, 0) the upper left corner.
namespace lightgrid {

/// 0xRRGGBB
[[nodiscard]] glm::vec3 hex_color(unsigned hex);

struct Canvas {
    int width = 0;
    int height = 0;
    std::vector<glm::vec3> pixels;

    Canvas(int w, int h, glm::vec3 background);

    [[nodiscard]] glm::vec3& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
    /// Mixes `color` into a pixel; outside of the picture nothing happens.
    void blend(int x, int y, glm::vec3 color, float opacity);
    void fill(glm::ivec2 corner, glm::ivec2 size, glm::vec3 color);
    /// A disc, and a ring of a pixel or so around it, both with smooth edges.
    void disc(glm::vec2 center, float radius, glm::vec3 color, glm::vec3 ring, float ring_width);
    void paste(const Canvas& other, glm::ivec2 corner);
    /// A line of text; `corner` is the upper left of its capitals. Returns its width.
    int text(glm::ivec2 corner, const std::string& text, glm::vec3 color, float cap_height = 11);

    /// The bytes of a PNG file.
    [[nodiscard]] std::string png() const;
    /// Throws Error (Fault::work) where the file cannot be written.
    void write_png(const std::filesystem::path& path) const;
};

}  // namespace lightgrid
