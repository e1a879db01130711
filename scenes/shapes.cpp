#include "scenes/shapes.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace lightgrid::scenes {
namespace {

Surface& surface_of(Shape& shape, int material) {
    Surface& surface = shape[material];
    surface.material = material;
    return surface;
}

void add_vertex(Surface& surface, glm::vec3 position, glm::vec3 normal, glm::vec2 uv) {
    surface.positions.push_back(position);
    surface.normals.push_back(normal);
    surface.uvs.push_back(uv);
}

void add_indices(Surface& surface, std::uint32_t base, std::span<const std::uint32_t> offsets) {
    for (const std::uint32_t offset : offsets) surface.indices.push_back(base + offset);
}

std::uint32_t next_vertex(const Surface& surface) {
    return static_cast<std::uint32_t>(surface.positions.size());
}

}  // namespace

void add_quad(Shape& shape, int material, glm::vec3 corner, glm::vec3 right, glm::vec3 up) {
    Surface& surface = surface_of(shape, material);
    const std::uint32_t base = next_vertex(surface);
    const glm::vec3 normal = glm::normalize(glm::cross(right, up));
    const float width = glm::length(right);
    const float height = glm::length(up);
    add_vertex(surface, corner, normal, {0, height});
    add_vertex(surface, corner + right, normal, {width, height});
    add_vertex(surface, corner + right + up, normal, {width, 0});
    add_vertex(surface, corner + up, normal, {0, 0});
    add_indices(surface, base, std::array<std::uint32_t, 6>{0, 1, 2, 0, 2, 3});
}

void add_box(Shape& shape, int material, glm::vec3 low, glm::vec3 high) {
    const glm::vec3 x{high.x - low.x, 0, 0};
    const glm::vec3 y{0, high.y - low.y, 0};
    const glm::vec3 z{0, 0, high.z - low.z};
    add_quad(shape, material, low + x + z, -z, y);  // +X
    add_quad(shape, material, low, z, y);           // -X
    add_quad(shape, material, low + y + z, x, -z);  // +Y
    add_quad(shape, material, low, x, z);           // -Y
    add_quad(shape, material, low + z, x, y);       // +Z
    add_quad(shape, material, low + x, -x, y);      // -Z
}

void add_rounded_box(Shape& shape, int material, glm::vec3 low, glm::vec3 high, float radius) {
    constexpr int per_quarter = 3;
    Surface& surface = surface_of(shape, material);
    const std::uint32_t base = next_vertex(surface);
    const glm::vec3 center = 0.5F * (low + high);
    const glm::vec3 reach = 0.5F * (high - low) - radius;  // of the corners' spheres from the centre

    // A sphere of latitudes and longitudes, cut into eight parts that are moved to the corners: rows and columns where
    // the cuts are exist twice, and the quads between them are the flat sides.
    constexpr int rows = 2 * (per_quarter + 1);
    constexpr int columns = 4 * (per_quarter + 1);
    for (int row = 0; row < rows; ++row) {
        const bool upper = row > per_quarter;
        const float latitude =
            glm::half_pi<float>() * static_cast<float>(row - per_quarter - (upper ? 1 : 0)) / per_quarter;
        for (int column = 0; column < columns; ++column) {
            const int quarter = column / (per_quarter + 1);
            const float longitude = glm::half_pi<float>() * static_cast<float>(column - quarter) / per_quarter;
            // Exactly zero at the poles, so that what meets there closes.
            const float flat = row == 0 || row == rows - 1 ? 0 : std::cos(latitude);
            const glm::vec3 direction{flat * std::cos(longitude), std::sin(latitude), -flat * std::sin(longitude)};
            const glm::vec3 octant{quarter == 0 || quarter == 3 ? 1 : -1, upper ? 1 : -1, quarter < 2 ? -1 : 1};
            const glm::vec3 position = center + octant * reach + radius * direction;
            add_vertex(surface, position, direction, {position.x + position.z, -position.y});
        }
    }
    const auto at = [&](int row, int column) {
        return base + static_cast<std::uint32_t>(row * columns + column % columns);
    };
    for (int row = 0; row + 1 < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            const std::array quad{at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column)};
            const bool first_pole = row == 0 && column % (per_quarter + 1) != per_quarter;
            const bool last_pole = row + 2 == rows && column % (per_quarter + 1) != per_quarter;
            if (!first_pole) surface.indices.insert(surface.indices.end(), {quad[0], quad[1], quad[2]});
            if (!last_pole) surface.indices.insert(surface.indices.end(), {quad[0], quad[2], quad[3]});
        }
    }
    for (const int row : {0, rows - 1}) {
        const int step = per_quarter + 1;
        const std::array quad{at(row, 0), at(row, step), at(row, 2 * step), at(row, 3 * step)};
        if (row == 0) {
            surface.indices.insert(surface.indices.end(), {quad[0], quad[2], quad[1], quad[0], quad[3], quad[2]});
        } else {
            surface.indices.insert(surface.indices.end(), {quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]});
        }
    }
}

void add_lathe(Shape& shape, int material, std::span<const glm::vec2> profile, int segments) {
    const float crease = std::cos(glm::quarter_pi<float>());
    Surface& surface = surface_of(shape, material);
    const auto normal_of = [&](std::size_t i) {  // of the segment from profile[i]
        const glm::vec2 along = glm::normalize(profile[i + 1] - profile[i]);
        return glm::vec2(along.y, -along.x);
    };
    float travelled = 0;
    for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
        const glm::vec2 normal = normal_of(i);
        glm::vec2 first = normal;
        glm::vec2 last = normal;
        if (i > 0 && glm::dot(normal_of(i - 1), normal) > crease) first = glm::normalize(normal_of(i - 1) + normal);
        if (i + 2 < profile.size() && glm::dot(normal_of(i + 1), normal) > crease) {
            last = glm::normalize(normal_of(i + 1) + normal);
        }
        const float length = glm::distance(profile[i], profile[i + 1]);
        const std::uint32_t base = next_vertex(surface);
        for (int segment = 0; segment <= segments; ++segment) {
            // The last column repeats the first bit for bit, so that the surface closes.
            const float angle =
                glm::two_pi<float>() * static_cast<float>(segment % segments) / static_cast<float>(segments);
            const glm::vec2 around{std::cos(angle), -std::sin(angle)};
            const float u = glm::two_pi<float>() * static_cast<float>(segment) / static_cast<float>(segments) *
                            std::max(profile[i].x, profile[i + 1].x);
            const auto turned = [&](glm::vec2 p) { return glm::vec3(p.x * around.x, p.y, p.x * around.y); };
            add_vertex(surface, turned(profile[i]), turned(first), {u, -travelled});
            add_vertex(surface, turned(profile[i + 1]), turned(last), {u, -travelled - length});
        }
        travelled += length;
        for (int segment = 0; segment < segments; ++segment) {
            const std::uint32_t at = base + 2 * static_cast<std::uint32_t>(segment);
            if (profile[i].x > 0) add_indices(surface, at, std::array<std::uint32_t, 3>{0, 2, 3});
            if (profile[i + 1].x > 0) add_indices(surface, at, std::array<std::uint32_t, 3>{0, 3, 1});
        }
    }
}

void add_strip(Shape& shape, int material, std::span<const glm::vec3> spine, glm::vec3 across) {
    Surface& surface = surface_of(shape, material);
    const std::uint32_t base = next_vertex(surface);
    for (std::size_t i = 0; i < spine.size(); ++i) {
        const glm::vec3 along = spine[std::min(i + 1, spine.size() - 1)] - spine[i == 0 ? 0 : i - 1];
        const glm::vec3 normal = glm::normalize(glm::cross(across, along));
        const float v = 1 - static_cast<float>(i) / static_cast<float>(spine.size() - 1);
        add_vertex(surface, spine[i] - across, normal, {0, v});
        add_vertex(surface, spine[i] + across, normal, {1, v});
    }
    for (std::size_t i = 0; i + 1 < spine.size(); ++i) {
        add_indices(surface, base + 2 * static_cast<std::uint32_t>(i), std::array<std::uint32_t, 6>{0, 1, 3, 0, 3, 2});
    }
}

void append(Shape& shape, const Shape& other, const glm::mat4& transform) {
    const glm::mat3 to_normal = glm::transpose(glm::inverse(glm::mat3(transform)));
    for (const auto& [material, from] : other) {
        Surface& surface = surface_of(shape, material);
        const std::uint32_t base = next_vertex(surface);
        for (std::size_t i = 0; i < from.positions.size(); ++i) {
            add_vertex(surface, glm::vec3(transform * glm::vec4(from.positions[i], 1)),
                       glm::normalize(to_normal * from.normals[i]), from.uvs[i]);
        }
        add_indices(surface, base, from.indices);
    }
}

void Blocks::fill(glm::vec3 low, glm::vec3 high) {
    steps_.push_back({low, high, true, {}});
}

void Blocks::carve(glm::vec3 low, glm::vec3 high, Paint paint) {
    steps_.push_back({low, high, false, paint});
}

void Blocks::add_to(Shape& shape) const {
    std::array<std::vector<float>, 3> planes;
    for (int axis = 0; axis < 3; ++axis) {
        for (const Step& step : steps_) planes[axis].insert(planes[axis].end(), {step.low[axis], step.high[axis]});
        std::sort(planes[axis].begin(), planes[axis].end());
        planes[axis].erase(std::unique(planes[axis].begin(), planes[axis].end()), planes[axis].end());
    }
    const glm::ivec3 cells(planes[0].size() - 1, planes[1].size() - 1, planes[2].size() - 1);

    // The last step that covers a cell; null outside.
    const auto step_at = [&](glm::ivec3 cell) -> const Step* {
        if (glm::any(glm::lessThan(cell, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(cell, cells)))
            return nullptr;
        const glm::vec3 low{planes[0][cell.x], planes[1][cell.y], planes[2][cell.z]};
        for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
            if (glm::all(glm::lessThanEqual(step->low, low)) && glm::all(glm::lessThan(low, step->high))) return &*step;
        }
        return nullptr;
    };

    using Corner = std::tuple<int, int, float, float, float>;  // material, side, position
    std::map<Corner, std::uint32_t> welded;
    for (int z = 0; z < cells.z; ++z) {
        for (int y = 0; y < cells.y; ++y) {
            for (int x = 0; x < cells.x; ++x) {
                const Step* here = step_at({x, y, z});
                if (here == nullptr || !here->solid) continue;
                for (int side = 0; side < 6; ++side) {
                    const int axis = side / 2;
                    const bool positive = side % 2 == 0;
                    glm::ivec3 beyond(x, y, z);
                    beyond[axis] += positive ? 1 : -1;
                    const Step* next = step_at(beyond);
                    if (next != nullptr && next->solid) continue;
                    const Paint paint = next == nullptr ? outside_ : next->paint;
                    const int material = axis != 1 ? paint.wall : positive ? paint.floor : paint.ceiling;

                    Surface& surface = surface_of(shape, material);
                    glm::vec3 normal(0);
                    normal[axis] = positive ? 1 : -1;
                    // (u, v, normal) right-handed, so the loop below is counter-clockwise seen from outside.
                    const int u = positive ? (axis + 1) % 3 : (axis + 2) % 3;
                    const int v = positive ? (axis + 2) % 3 : (axis + 1) % 3;
                    std::array<std::uint32_t, 4> loop{};
                    for (int corner = 0; corner < 4; ++corner) {
                        glm::ivec3 index(x, y, z);
                        index[axis] += positive ? 1 : 0;
                        index[u] += corner == 1 || corner == 2 ? 1 : 0;
                        index[v] += corner >= 2 ? 1 : 0;
                        const glm::vec3 position{planes[0][index.x], planes[1][index.y], planes[2][index.z]};
                        const auto [found, is_new] = welded.try_emplace(
                            {material, side, position.x, position.y, position.z}, next_vertex(surface));
                        if (is_new) {
                            const glm::vec2 uv = axis == 1   ? glm::vec2(position.x, position.z)
                                                 : axis == 0 ? glm::vec2(position.z, -position.y)
                                                             : glm::vec2(position.x, -position.y);
                            add_vertex(surface, position, normal, uv);
                        }
                        loop[corner] = found->second;
                    }
                    surface.indices.insert(surface.indices.end(),
                                           {loop[0], loop[1], loop[2], loop[0], loop[2], loop[3]});
                }
            }
        }
    }
}

}  // namespace lightgrid::scenes
