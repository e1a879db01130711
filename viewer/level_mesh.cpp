#include "viewer/level_mesh.h"

#include "core/parallel.h"
#include "viewer/normals.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <unordered_map>

namespace lightgrid {
namespace {

/// Triangles of a draw are cut into parts of about as many, each with bounds of its own, to be left out when out of
/// sight.
constexpr std::size_t triangles_per_part = 4096;
/// Rounds of halving: an edge becomes a thousandth of what it was.
constexpr int most_rounds = 10;

std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
    return (hash ^ value) * 0x9e3779b97f4a7c15U ^ (hash >> 29);
}

struct HashPosition {
    std::size_t operator()(const glm::vec3& p) const {
        std::array<std::uint32_t, 3> bits{};
        std::memcpy(bits.data(), &p, sizeof bits);
        return mixed(mixed(mixed(0, bits[0]), bits[1]), bits[2]);
    }
};

struct HashVertex {
    std::size_t operator()(const LevelVertex& v) const {
        std::uint64_t hash = HashPosition()(v.position);
        for (int i = 0; i < 3; ++i) hash = mixed(hash, static_cast<std::uint64_t>(v.normal[i]));
        hash = mixed(hash, HashPosition()({v.base_color_uv, v.emission_uv.x}));
        return mixed(hash, v.color.r);
    }
};

glm::i16vec4 packed(glm::dvec3 normal) {
    return {glm::i16vec3(glm::round(32767.0 * normal)), 0};
}

glm::vec3 unpacked(glm::i16vec4 normal) {
    const glm::vec3 n = glm::vec3(normal);
    const float length = glm::length(n);
    return length > 0 ? n / length : glm::vec3(0, 1, 0);
}

// ---- one mesh ------------------------------------------------------------------------------------------------------

/// The triangles of a mesh with one vertex for all corners that look alike.
struct Welded {
    std::vector<LevelVertex> vertices;
    std::vector<glm::uvec3> triangles;
};

glm::vec2 uv_of(const Mesh& mesh, const TextureUse& use, std::uint32_t vertex) {
    if (!use.used()) return glm::vec2(0);
    return use.transform * glm::vec3(mesh.uv_sets[static_cast<std::size_t>(use.uv_set)][vertex], 1);
}

Welded weld(const Scene& scene, const Mesh& mesh) {
    const Material& material = scene.materials[static_cast<std::size_t>(mesh.material)];
    const auto normals = corner_normals(mesh.positions, mesh.triangles, level_crease_deg);
    Welded surface;
    std::unordered_map<LevelVertex, std::uint32_t, HashVertex> known;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        glm::uvec3 triangle;
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t from = mesh.triangles[t][k];
            LevelVertex vertex;
            vertex.position = mesh.positions[from] + 0.0F;
            vertex.normal = packed(normals[t][k]);
            vertex.base_color_uv = uv_of(mesh, material.base_color_texture, from);
            vertex.emission_uv = uv_of(mesh, material.emission_texture, from);
            vertex.transmission_uv = uv_of(mesh, material.transmission_texture, from);
            if (!mesh.colors.empty()) vertex.color = mesh.colors[from];
            const auto [found, is_new] = known.try_emplace(vertex, static_cast<std::uint32_t>(surface.vertices.size()));
            if (is_new) surface.vertices.push_back(vertex);
            triangle[k] = found->second;
        }
        surface.triangles.push_back(triangle);
    }
    return surface;
}

LevelVertex between(const LevelVertex& a, const LevelVertex& b) {
    LevelVertex middle;
    middle.position = 0.5F * (a.position + b.position);
    middle.normal = packed(glm::normalize(glm::dvec3(unpacked(a.normal) + unpacked(b.normal))));
    middle.base_color_uv = 0.5F * (a.base_color_uv + b.base_color_uv);
    middle.emission_uv = 0.5F * (a.emission_uv + b.emission_uv);
    middle.transmission_uv = 0.5F * (a.transmission_uv + b.transmission_uv);
    middle.color = glm::u16vec4((glm::uvec4(a.color) + glm::uvec4(b.color)) / 2U);
    return middle;
}

/// Halves every edge that is longer than `longest`, round after round. Returns false as soon as there are more than
/// `most` vertices.
bool divide(Welded& surface, double longest, std::size_t most) {
    for (int round = 0; round < most_rounds; ++round) {
        std::unordered_map<std::uint64_t, std::uint32_t> middles;
        const auto middle_of = [&](std::uint32_t a, std::uint32_t b) {
            const std::uint64_t key = std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
            const auto [found, is_new] = middles.try_emplace(key, static_cast<std::uint32_t>(surface.vertices.size()));
            if (is_new) surface.vertices.push_back(between(surface.vertices[a], surface.vertices[b]));
            return found->second;
        };
        std::vector<glm::uvec3> divided;
        divided.reserve(surface.triangles.size());
        for (const glm::uvec3& t : surface.triangles) {
            std::array<bool, 3> split{};
            int splits = 0;
            for (int k = 0; k < 3; ++k) {
                const glm::dvec3 a = surface.vertices[t[k]].position;
                const glm::dvec3 b = surface.vertices[t[(k + 1) % 3]].position;
                split[k] = glm::distance(a, b) > longest;
                splits += split[k] ? 1 : 0;
            }
            if (splits == 0) {
                divided.push_back(t);
                continue;
            }
            // Turned so that the edges to split come first.
            int first = 0;
            if (splits == 1) {
                while (!split[first]) ++first;
            } else if (splits == 2) {
                while (split[(first + 2) % 3]) ++first;
            }
            const std::uint32_t a = t[first];
            const std::uint32_t b = t[(first + 1) % 3];
            const std::uint32_t c = t[(first + 2) % 3];
            const std::uint32_t ab = middle_of(a, b);
            if (splits == 1) {
                divided.insert(divided.end(), {{a, ab, c}, {ab, b, c}});
                continue;
            }
            const std::uint32_t bc = middle_of(b, c);
            if (splits == 2) {
                divided.insert(divided.end(), {{ab, b, bc}, {a, ab, bc}, {a, bc, c}});
                continue;
            }
            const std::uint32_t ca = middle_of(c, a);
            divided.insert(divided.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        if (surface.vertices.size() > most) return false;
        if (middles.empty()) return true;
        surface.triangles = std::move(divided);
    }
    return true;
}

// ---- the level -----------------------------------------------------------------------------------------------------

/// Where a mesh stands: in the level itself, or in many places.
struct Placing {
    int mesh = 0;
    std::vector<glm::mat4x3> to_level;
    bool mirrored = false;

    /// The most that a length grows by.
    [[nodiscard]] double scale() const {
        double most = 0;
        for (const glm::mat4x3& m : to_level) {
            for (int axis = 0; axis < 3; ++axis) most = std::max(most, static_cast<double>(glm::length(m[axis])));
        }
        return most;
    }
};

std::vector<Placing> placings_of(const Scene& scene) {
    std::vector<Placing> placings;
    for (const int mesh : scene.placed) placings.push_back({mesh, {glm::mat4x3(1)}, false});
    std::map<std::pair<int, bool>, std::vector<glm::mat4x3>> instances;
    for (const Instance& instance : scene.instances) {
        instances[{instance.model, instance.mirrored}].push_back(instance.to_level);
    }
    for (const auto& [key, to_level] : instances) {
        for (const int mesh : scene.models[static_cast<std::size_t>(key.first)].meshes) {
            placings.push_back({mesh, to_level, key.second});
        }
    }
    return placings;
}

/// The longest edge of each mesh, in its own space, that none of its placings makes longer than `longest`.
std::vector<double> longest_edges(const Scene& scene, const std::vector<Placing>& placings, double longest) {
    std::vector<double> scales(scene.meshes.size(), 0);
    for (const Placing& placing : placings) {
        double& scale = scales[static_cast<std::size_t>(placing.mesh)];
        scale = std::max(scale, placing.scale());
    }
    std::vector<double> edges(scene.meshes.size());
    for (std::size_t i = 0; i < edges.size(); ++i) edges[i] = longest / std::max(scales[i], 1e-12);
    return edges;
}

Box bounds_in_level(const Welded& surface, std::span<const glm::uvec3> triangles, const Placing& placing) {
    Box own;
    for (const glm::uvec3& t : triangles) {
        for (int k = 0; k < 3; ++k) own.extend(surface.vertices[t[k]].position);
    }
    Box bounds;
    for (const glm::mat4x3& to_level : placing.to_level) {
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 pick(corner & 1, corner / 2 & 1, corner / 4);
            bounds.extend(glm::dvec3(to_level * glm::vec4(own.min + pick * own.size(), 1)));
        }
    }
    return bounds;
}

/// Sorts triangles into parts that are near one another, by halving along the longest axis of their centres.
void split_into_parts(const Welded& surface, std::span<glm::uvec3> triangles,
                      std::vector<std::span<const glm::uvec3>>& parts) {
    if (triangles.size() <= triangles_per_part) {
        parts.push_back(triangles);
        return;
    }
    const auto center = [&](const glm::uvec3& t) {
        return surface.vertices[t.x].position + surface.vertices[t.y].position + surface.vertices[t.z].position;
    };
    Box box;
    for (const glm::uvec3& t : triangles) box.extend(center(t));
    const glm::dvec3 size = box.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const auto half = static_cast<std::ptrdiff_t>(triangles.size() / 2);
    std::nth_element(triangles.begin(), triangles.begin() + half, triangles.end(),
                     [&](const glm::uvec3& a, const glm::uvec3& b) { return center(a)[axis] < center(b)[axis]; });
    split_into_parts(surface, triangles.first(static_cast<std::size_t>(half)), parts);
    split_into_parts(surface, triangles.subspan(static_cast<std::size_t>(half)), parts);
}

glm::vec4 light_on(const LookUp& look_up, glm::dvec3 position, glm::vec3 normal) {
    return {surface_irradiance(look_up, position, normal), surface_error(look_up, position, normal)};
}

}  // namespace

std::vector<LevelDraw> in_each_place(const LevelDraw& draw) {
    std::vector<LevelDraw> places;
    for (int i = 0; i < draw.instance_count; ++i) {
        places.push_back(draw);
        places.back().first_instance += i;
        places.back().instance_count = 1;
        places.back().first_light += static_cast<std::uint32_t>(i) * draw.light_stride;
    }
    return places;
}

LevelMesh build_level_mesh(const Scene& scene, double longest_edge, std::uint32_t most_rows) {
    const std::vector<Placing> placings = placings_of(scene);
    std::vector<std::size_t> uses(scene.meshes.size(), 0);
    for (const Placing& placing : placings) uses[static_cast<std::size_t>(placing.mesh)] += placing.to_level.size();

    std::vector<Welded> whole(scene.meshes.size());
    std::size_t rows_undivided = 0;
    for (std::size_t i = 0; i < whole.size(); ++i) {
        if (uses[i] > 0) whole[i] = weld(scene, scene.meshes[i]);
        rows_undivided += uses[i] * whole[i].vertices.size();
    }
    LevelMesh level;
    std::vector<Welded> surfaces;
    for (level.longest_edge = longest_edge;; level.longest_edge *= 1.5) {
        const std::vector<double> longest = longest_edges(scene, placings, level.longest_edge);
        surfaces = whole;
        std::size_t rows = 0;
        bool fits = true;
        for (std::size_t i = 0; i < surfaces.size() && fits; ++i) {
            if (uses[i] == 0) continue;
            fits = divide(surfaces[i], longest[i], most_rows);
            rows += uses[i] * surfaces[i].vertices.size();
            fits = fits && rows <= most_rows;
        }
        if (fits) break;
        if (rows_undivided > most_rows) {
            level.longest_edge = std::numeric_limits<double>::infinity();
            surfaces = std::move(whole);
            break;
        }
    }

    std::vector<std::uint32_t> first_vertices(surfaces.size());
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        first_vertices[i] = static_cast<std::uint32_t>(level.vertices.size());
        level.vertices.insert(level.vertices.end(), surfaces[i].vertices.begin(), surfaces[i].vertices.end());
    }
    level.instances.emplace_back(1);
    for (const Placing& placing : placings) {
        const auto mesh = static_cast<std::size_t>(placing.mesh);
        Welded& surface = surfaces[mesh];
        if (surface.triangles.empty()) continue;
        LevelDraw draw;
        draw.material = scene.meshes[mesh].material;
        draw.mirrored = placing.mirrored;
        draw.instance_count = static_cast<int>(placing.to_level.size());
        draw.first_vertex = first_vertices[mesh];
        draw.light_stride = static_cast<std::uint32_t>(surface.vertices.size());
        draw.first_light = level.light_rows;
        level.light_rows += draw.light_stride * static_cast<std::uint32_t>(draw.instance_count);
        const bool in_the_level = placing.to_level.size() == 1 && placing.to_level[0] == glm::mat4x3(1);
        if (!in_the_level) {
            draw.first_instance = static_cast<int>(level.instances.size());
            level.instances.insert(level.instances.end(), placing.to_level.begin(), placing.to_level.end());
        }
        std::vector<std::span<const glm::uvec3>> parts;
        split_into_parts(surface, surface.triangles, parts);
        for (const std::span<const glm::uvec3> part : parts) {
            draw.first_index = static_cast<std::uint32_t>(level.indices.size());
            draw.index_count = static_cast<std::uint32_t>(3 * part.size());
            draw.bounds = bounds_in_level(surface, part, placing);
            level.draws.push_back(draw);
            for (const glm::uvec3& t : part) {
                for (int k = 0; k < 3; ++k) level.indices.push_back(draw.first_vertex + t[k]);
            }
        }
    }
    return level;
}

std::vector<VertexLight> light_level(const LevelMesh& mesh, glm::dvec3 origin, const LookUp& look_up) {
    return light_level(mesh, origin,
                       [&](glm::dvec3 position, glm::vec3 normal) { return light_on(look_up, position, normal); });
}

std::vector<VertexLight> light_level(const LevelMesh& mesh, glm::dvec3 origin,
                                     const std::function<glm::vec4(glm::dvec3, glm::vec3)>& value) {
    std::vector<VertexLight> light(mesh.light_rows);
    const LevelDraw* before = nullptr;
    for (const LevelDraw& draw : mesh.draws) {
        // Parts of one placing share their rows.
        if (before != nullptr && before->first_light == draw.first_light) continue;
        before = &draw;
        for (int i = 0; i < draw.instance_count; ++i) {
            const glm::mat4x3& to_level =
                mesh.instances[static_cast<std::size_t>(draw.first_instance) + static_cast<std::size_t>(i)];
            // Normals turn as planes do; the front stays the front of a mirrored instance.
            const glm::mat3 normals = glm::transpose(glm::inverse(glm::mat3(to_level)));
            const std::size_t first = draw.first_light + static_cast<std::size_t>(i) * draw.light_stride;
            for_each_index(draw.light_stride, [&](std::size_t v) {
                const LevelVertex& vertex = mesh.vertices[draw.first_vertex + v];
                const glm::dvec3 position = origin + glm::dvec3(to_level * glm::vec4(vertex.position, 1));
                const glm::vec3 normal = glm::normalize(normals * unpacked(vertex.normal));
                light[first + v].front = value(position, normal);
                light[first + v].back = value(position, -normal);
            });
        }
    }
    return light;
}

}  // namespace lightgrid
