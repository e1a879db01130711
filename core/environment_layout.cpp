#include "core/environment_layout.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <span>

namespace lightgrid {
namespace {

constexpr float pi = std::numbers::pi_v<float>;

struct Name {
    EnvironmentLayout layout;
    std::string_view text;
};
constexpr std::array names{
    Name{EnvironmentLayout::automatic, "auto"},
    Name{EnvironmentLayout::equirectangular, "equirect"},
    Name{EnvironmentLayout::vertical_cross, "vertical-cross"},
    Name{EnvironmentLayout::horizontal_cross, "horizontal-cross"},
    Name{EnvironmentLayout::strip, "strip"},
    Name{EnvironmentLayout::angular, "angular"},
    Name{EnvironmentLayout::openexr_latlong, "openexr-latlong"},
    Name{EnvironmentLayout::openexr_cube, "openexr-cube"},
};

/// A point of a rectangle of pixels, in pixels from the centre of its first.
struct Spot {
    glm::ivec2 corner{0};
    glm::ivec2 size{0};
    glm::vec2 position{0};
};

/// Bilinear between the pixels of the rectangle, constant beyond the outermost centres.
glm::vec3 interpolate(const RadianceImage& image, const Spot& spot) {
    const glm::vec2 p = glm::clamp(spot.position, glm::vec2(0), glm::vec2(spot.size - 1));
    const glm::ivec2 first = glm::min(glm::ivec2(p), glm::max(spot.size - 2, glm::ivec2(0)));
    const glm::ivec2 second = glm::min(first + 1, spot.size - 1);
    const glm::vec2 t = p - glm::vec2(first);
    const auto pixel = [&](int x, int y) { return image.at(spot.corner.x + x, spot.corner.y + y); };
    return glm::mix(glm::mix(pixel(first.x, first.y), pixel(second.x, first.y), t.x),
                    glm::mix(pixel(first.x, second.y), pixel(second.x, second.y), t.x), t.y);
}

/// A face of a cube: where it looks, what is right and down in it, and its column and row in the picture.
struct Face {
    glm::vec3 forward;
    glm::vec3 right;
    glm::vec3 down;
    glm::ivec2 cell;
};
using Faces = std::array<Face, 6>;

constexpr glm::vec3 plus_x(1, 0, 0), plus_y(0, 1, 0), plus_z(0, 0, 1);
constexpr glm::vec3 minus_x(-1, 0, 0), minus_y(0, -1, 0), minus_z(0, 0, -1);

constexpr Faces vertical_cross_faces{{{minus_z, plus_x, minus_y, {1, 1}},
                                      {minus_x, minus_z, minus_y, {0, 1}},
                                      {plus_x, plus_z, minus_y, {2, 1}},
                                      {plus_y, plus_x, minus_z, {1, 0}},
                                      {minus_y, plus_x, plus_z, {1, 2}},
                                      {plus_z, plus_x, plus_y, {1, 3}}}};
constexpr Faces horizontal_cross_faces{{{minus_z, plus_x, minus_y, {1, 1}},
                                        {minus_x, minus_z, minus_y, {0, 1}},
                                        {plus_x, plus_z, minus_y, {2, 1}},
                                        {plus_y, plus_x, minus_z, {1, 0}},
                                        {minus_y, plus_x, plus_z, {1, 2}},
                                        {plus_z, minus_x, minus_y, {3, 1}}}};
constexpr Faces horizontal_strip_faces{{{plus_x, minus_z, minus_y, {0, 0}},
                                        {minus_x, plus_z, minus_y, {1, 0}},
                                        {plus_y, plus_x, plus_z, {2, 0}},
                                        {minus_y, plus_x, minus_z, {3, 0}},
                                        {plus_z, plus_x, minus_y, {4, 0}},
                                        {minus_z, minus_x, minus_y, {5, 0}}}};
constexpr Faces openexr_cube_faces{{{plus_x, plus_z, minus_y, {0, 0}},
                                    {minus_x, minus_z, minus_y, {0, 1}},
                                    {plus_y, plus_x, minus_z, {0, 2}},
                                    {minus_y, plus_x, plus_z, {0, 3}},
                                    {plus_z, minus_x, minus_y, {0, 4}},
                                    {minus_z, plus_x, minus_y, {0, 5}}}};

/// A picture made of six squares.
struct CubeLayout {
    Faces faces;
    glm::ivec2 cells;               // columns and rows of squares
    bool centres_on_edges = false;  // the outermost pixel centres lie on the edges of the face

    [[nodiscard]] Spot spot(int face_size, glm::vec3 direction) const {
        const Face* best = &faces[0];
        for (const Face& face : faces)
            if (glm::dot(face.forward, direction) > glm::dot(best->forward, direction)) best = &face;
        const float depth = glm::dot(best->forward, direction);
        const glm::vec2 on_face = glm::vec2(glm::dot(best->right, direction), glm::dot(best->down, direction)) / depth;
        const auto n = static_cast<float>(face_size);
        const glm::vec2 from_edge = 0.5F * (on_face + 1.0F);  // [0, 1]^2
        return {best->cell * face_size, glm::ivec2(face_size),
                centres_on_edges ? from_edge * (n - 1) : from_edge * n - 0.5F};
    }
};

Faces turned_down(Faces faces) {
    for (Face& face : faces) std::swap(face.cell.x, face.cell.y);
    return faces;
}

CubeLayout cube_layout(EnvironmentLayout layout, bool wide) {
    switch (layout) {
        case EnvironmentLayout::vertical_cross:
            return {vertical_cross_faces, {3, 4}};
        case EnvironmentLayout::horizontal_cross:
            return {horizontal_cross_faces, {4, 3}};
        case EnvironmentLayout::openexr_cube:
            return {openexr_cube_faces, {1, 6}, true};
        default:
            break;
    }
    return wide ? CubeLayout{horizontal_strip_faces, {6, 1}} : CubeLayout{turned_down(horizontal_strip_faces), {1, 6}};
}

Spot angular_spot(int size, glm::vec3 direction) {
    const auto n = static_cast<float>(size);
    const float from_axis = std::hypot(direction.x, direction.y);
    // Interpolation must not reach beyond the circle, where the picture says nothing.
    const float farthest = std::max(0.5F, 1 - 3 / n);
    const float radius = std::min(std::atan2(from_axis, -direction.z) / pi, farthest);
    const glm::vec2 around = from_axis > 0 ? glm::vec2(direction.x, -direction.y) / from_axis : glm::vec2(0);
    return {glm::ivec2(0), glm::ivec2(size), 0.5F * n * (1.0F + radius * around) - 0.5F};
}

Spot latlong_spot(glm::ivec2 size, glm::vec3 direction) {
    const float longitude = std::atan2(direction.x, direction.z);
    const float latitude = std::atan2(direction.y, std::hypot(direction.x, direction.z));
    const glm::vec2 from_edge(0.5F - longitude / (2 * pi), 0.5F - latitude / pi);
    return {glm::ivec2(0), size, from_edge * glm::vec2(size - 1)};
}

/// Average of light(direction) over a pixel of an equirectangular image, from samples x samples points.
struct Average {
    glm::vec3 value{0};
    float contrast = 0;  // of the points' luminance
};

template <typename Light>
Average average_over_pixel(glm::ivec2 size, glm::ivec2 pixel, int samples, const Light& light) {
    const float top = std::cos(pi * static_cast<float>(pixel.y) / static_cast<float>(size.y));
    const float bottom = std::cos(pi * static_cast<float>(pixel.y + 1) / static_cast<float>(size.y));
    const float step = 1 / static_cast<float>(samples);
    glm::dvec3 sum(0);
    float lowest = std::numeric_limits<float>::infinity();
    float highest = 0;
    for (int i = 0; i < samples; ++i) {
        const float y = glm::mix(top, bottom, (static_cast<float>(i) + 0.5F) * step);
        const float from_axis = std::sqrt(std::max(1 - y * y, 0.0F));
        for (int j = 0; j < samples; ++j) {
            const float u =
                (static_cast<float>(pixel.x) + (static_cast<float>(j) + 0.5F) * step) / static_cast<float>(size.x);
            const float azimuth = 2 * pi * (u - 0.5F);
            const glm::vec3 value = light(glm::vec3(from_axis * std::cos(azimuth), y, from_axis * std::sin(azimuth)));
            sum += value;
            lowest = std::min(lowest, luminance(value));
            highest = std::max(highest, luminance(value));
        }
    }
    return {glm::vec3(sum / static_cast<double>(samples * samples)), highest - lowest};
}

/// The light as an equirectangular image. Few points find where it varies; there, and one pixel around, where they may
/// have missed the fringe of something small and bright, many are taken.
template <typename Light>
RadianceImage resample(glm::ivec2 size, const Light& light) {
    constexpr int few = 2;
    constexpr int many = 8;
    RadianceImage image{size.x, size.y, std::vector<glm::vec3>(static_cast<std::size_t>(size.x) * size.y)};
    std::vector<std::uint8_t> varies(image.pixels.size());
    const auto index = [&](int x, int y) {
        return static_cast<std::size_t>(std::clamp(y, 0, size.y - 1)) * size.x + (x + size.x) % size.x;
    };
    for_each_index(static_cast<std::size_t>(size.y), [&](std::size_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < size.x; ++x) {
            const Average average = average_over_pixel(size, {x, y}, few, light);
            image.at(x, y) = average.value;
            varies[index(x, y)] = average.contrast > luminance(average.value) ? 1 : 0;
        }
    });
    for_each_index(static_cast<std::size_t>(size.y), [&](std::size_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < size.x; ++x) {
            bool near = false;
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i) near = near || varies[index(x + i, y + j)] != 0;
            if (near) image.at(x, y) = average_over_pixel(size, {x, y}, many, light).value;
        }
    });
    return image;
}

Error wrong_shape(const RadianceImage& image, EnvironmentLayout layout) {
    return Error(fmt::format("{} x {} pixels do not fit the layout {}", image.width, image.height, name_of(layout)), "",
                 "Crop or scale it, or name another layout.");
}

}  // namespace

std::string_view name_of(EnvironmentLayout layout) noexcept {
    return std::find_if(names.begin(), names.end(), [&](const Name& name) { return name.layout == layout; })->text;
}

EnvironmentLayout parse_environment_layout(std::string_view text) {
    std::string all;
    for (const Name& name : names) {
        if (name.text == text) return name.layout;
        all += fmt::format("{}{}", all.empty() ? "" : ", ", name.text);
    }
    throw Error(fmt::format("unknown environment layout \"{}\"", text), "", fmt::format("Known are {}.", all));
}

EnvironmentLayout layout_of_shape(int width, int height) noexcept {
    const std::int64_t w = width;
    const std::int64_t h = height;
    if (w == h) return EnvironmentLayout::angular;
    if (3 * w == 4 * h) return EnvironmentLayout::horizontal_cross;
    if (4 * w == 3 * h) return EnvironmentLayout::vertical_cross;
    if (w == 6 * h || h == 6 * w) return EnvironmentLayout::strip;
    if (100 * std::abs(w - 2 * h) <= h) return EnvironmentLayout::equirectangular;
    return EnvironmentLayout::automatic;
}

RadianceImage to_equirectangular(RadianceImage image, EnvironmentLayout layout) {
    const glm::ivec2 size(image.width, image.height);
    switch (layout) {
        case EnvironmentLayout::automatic:
        case EnvironmentLayout::equirectangular:
            return image;
        case EnvironmentLayout::openexr_latlong:
            return resample(size,
                            [&](glm::vec3 direction) { return interpolate(image, latlong_spot(size, direction)); });
        case EnvironmentLayout::angular:
            if (size.x != size.y) throw wrong_shape(image, layout);
            return resample({2 * size.x, size.x},
                            [&](glm::vec3 direction) { return interpolate(image, angular_spot(size.x, direction)); });
        default:
            break;
    }
    const CubeLayout cube = cube_layout(layout, size.x > size.y);
    const int face_size = size.x / cube.cells.x;
    if (face_size < 1 || size != face_size * cube.cells) throw wrong_shape(image, layout);
    return resample({4 * face_size, 2 * face_size},
                    [&](glm::vec3 direction) { return interpolate(image, cube.spot(face_size, direction)); });
}

}  // namespace lightgrid
