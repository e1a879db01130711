#include "probes/shut_out.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>

namespace lightgrid {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr int bounces = 4;
constexpr std::size_t paths_from_points = 4096;
constexpr std::size_t paths_from_lamp = 512;
constexpr int points_tried = 4;  // at each vertex of a lamp's path
constexpr double least_around = 1.0 / 16;  // of the points: refined grids have most where light is, outside of a dome
constexpr int directions_tried = 8;        // upwards, of a point that a mesh may be all around
constexpr int most_layers = 64;            // along a ray

/// A direction towards a light, and how far it is free to go; none: nothing comes from there.
struct Towards {
    glm::vec3 direction{0};
    float distance = 0;
};

bool shines(const PathTracer& paths, std::size_t light) {
    return paths.sources().light(light) != LightSources::off &&
           paths.tracer().scene().lights[light].intensity != glm::vec3(0);
}

bool is_free(const Tracer& tracer, glm::vec3 from, const Towards& towards) {
    return tracer.transmittance(from, towards.direction, towards.distance) != glm::vec3(0);
}

int node_of(const Scene& scene, const Tracer& tracer, const SurfaceId& id) {
    return id.instance == SurfaceId::none ? tracer.mesh(id).node
                                          : scene.instances[id.instance - scene.placed.size()].node;
}

bool stops(const Scene& scene, const Surface& surface, const Hit& hit) {
    return passed_share(surface_at(scene, *surface.mesh, hit.id.triangle, hit.barycentric)) == glm::vec3(0);
}

/// The nodes whose meshes let nothing through along a ray that has no end.
std::set<int> nodes_in_the_way(const Tracer& tracer, glm::vec3 from, glm::vec3 direction) {
    const Scene& scene = tracer.scene();
    std::set<int> nodes;
    Hit hit;
    for (int layer = 0; layer < most_layers; ++layer) {
        hit = tracer.closest_hit(from, direction, infinity, hit);
        if (!hit.found()) break;
        const Surface surface = tracer.surface(hit, direction);
        if (!stops(scene, surface, hit)) continue;
        nodes.insert(node_of(scene, tracer, hit.id));
        from = surface.leave(direction);
        hit = {};
    }
    return nodes;
}

/// The first surface along a ray that stops light.
struct Stop {
    Hit hit;
    Surface surface;
};
std::optional<Stop> first_stop(const Tracer& tracer, glm::vec3 from, glm::vec3 direction, float distance = infinity) {
    Hit hit;
    for (int layer = 0; layer < most_layers; ++layer) {
        hit = tracer.closest_hit(from, direction, distance, hit);
        if (!hit.found()) return {};
        const Surface surface = tracer.surface(hit, direction);
        if (stops(tracer.scene(), surface, hit)) return Stop{hit, surface};
    }
    return {};
}

/// A ray that a surface reflects, on the side that `direction` came from.
struct Ray {
    glm::vec3 origin{0};
    glm::vec3 direction{0};
};
Ray reflected(const Surface& surface, RandomStream& random) {
    const glm::vec3 normal = surface.front ? surface.normal : -surface.normal;
    const glm::vec3 direction = cosine_direction(normal, random.next2());
    return {surface.leave(normal), direction};
}

/// Of what stands in the level, relative to Scene::origin.
std::map<int, Box> bounds_by_node(const Scene& scene) {
    std::map<int, Box> bounds;
    for (const int mesh : scene.placed) {
        Box& box = bounds[scene.meshes[mesh].node];
        for (const glm::vec3& position : scene.meshes[mesh].positions) box.extend(position);
    }
    for (const Instance& instance : scene.instances) {
        Box& box = bounds[instance.node];
        for (const int mesh : scene.models[instance.model].meshes)
            for (const glm::vec3& position : scene.meshes[mesh].positions)
                box.extend(instance.to_level * glm::vec4(position, 1));
    }
    return bounds;
}

bool is_within(const Box& inner, const Box& outer) {
    const glm::dvec3 slack = 0.01 * outer.size();  // grids may reach a little beyond what they are for
    return glm::all(glm::greaterThanEqual(inner.min, outer.min - slack)) &&
           glm::all(glm::lessThanEqual(inner.max, outer.max + slack));
}

Box bounds_of(std::span<const glm::vec3> points) {
    Box box;
    for (const glm::vec3& point : points) box.extend(point);
    return box;
}

bool encloses_the_rest(const std::map<int, Box>& bounds, int node) {
    const auto around = bounds.find(node);
    return around != bounds.end() && std::all_of(bounds.begin(), bounds.end(), [&](const auto& other) {
               return other.second.empty() || is_within(other.second, around->second);
           });
}

/// Whether a node's mesh is met in each of some directions upwards.
bool is_around(const Tracer& tracer, int node, glm::vec3 point, RandomStream& random) {
    for (int i = 0; i < directions_tried; ++i) {
        glm::vec3 direction = sphere_direction(random.next2());
        direction.y = std::abs(direction.y);
        if (nodes_in_the_way(tracer, point, direction).count(node) == 0) return false;
    }
    return true;
}

/// The mesh that alone keeps a light at infinity from the points that it is all around; none: light arrives there, or
/// no one mesh does.
///
/// aim  draws a direction to the light
std::optional<ShutOut> shut_out_by(const Tracer& tracer, std::span<const glm::vec3> points,
                                   const std::function<std::optional<Towards>(RandomStream&)>& aim, bool only_upwards) {
    struct Path {
        glm::vec3 start{0};
        bool is_lit = false;
        bool has_aimed = false;    // straight from its start,
        std::set<int> in_the_way;  // where these nodes are met
    };
    std::vector<Path> traced(paths_from_points);
    for_each_index(traced.size(), [&](std::size_t i) {
        Path& path = traced[i];
        RandomStream random(mix_bits(0x5107, i));
        path.start = points[i * points.size() / traced.size()];
        glm::vec3 at = path.start;
        glm::vec3 direction = sphere_direction(random.next2());
        for (int bounce = 0; bounce < bounces; ++bounce) {
            if (const std::optional<Towards> towards = aim(random)) {
                if (is_free(tracer, at, *towards)) {
                    path.is_lit = true;
                    return;
                }
                if (bounce == 0 && (!only_upwards || towards->direction.y > 0)) {
                    path.has_aimed = true;
                    path.in_the_way = nodes_in_the_way(tracer, at, towards->direction);
                }
            }
            const std::optional<Stop> stop = first_stop(tracer, at, direction);
            if (!stop) return;
            const Ray ray = reflected(stop->surface, random);
            at = ray.origin;
            direction = ray.direction;
        }
    });
    const bool is_dark = std::none_of(traced.begin(), traced.end(), [](const Path& path) { return path.is_lit; });
    std::set<int> alone;
    for (const Path& path : traced)
        if (path.in_the_way.size() == 1) alone.insert(path.in_the_way.begin(), path.in_the_way.end());
    if (alone.empty()) return {};
    const std::map<int, Box> bounds = bounds_by_node(tracer.scene());
    for (const int node : alone) {
        if (!encloses_the_rest(bounds, node)) continue;
        std::atomic<std::size_t> around = 0;
        std::atomic<bool> lets_light_in = false;
        for_each_index(traced.size(), [&](std::size_t i) {
            const Path& path = traced[i];
            RandomStream random(mix_bits(0xd03e, i));
            if (lets_light_in || !is_around(tracer, node, path.start, random)) return;
            ++around;
            if (path.is_lit || (path.has_aimed && path.in_the_way.count(node) == 0)) lets_light_in = true;
        });
        if (!lets_light_in && static_cast<double>(around) >= least_around * paths_from_points)
            return ShutOut{"", node, is_dark};
    }
    return {};
}

/// Whether a lamp's light gets to any point, straight or by a few surfaces, as far as few paths tell; and the mesh that
/// stops all of its rays.
std::optional<ShutOut> shut_in(const Tracer& tracer, std::span<const glm::vec3> points, const Light& lamp) {
    const Scene& scene = tracer.scene();
    const auto sees_a_point = [&](glm::vec3 from, RandomStream& random) {
        for (int i = 0; i < points_tried; ++i) {
            const auto index = static_cast<std::size_t>(random.next_double() * static_cast<double>(points.size()));
            if (tracer.transmittance(from, points[index] - from, 1) != glm::vec3(0)) return true;
        }
        return false;
    };
    for (const glm::vec3& point : points) {
        const PunctualLight light = punctual_light_at(lamp, point);
        if (light.irradiance != glm::vec3(0) && is_free(tracer, point, {light.direction, light.free_distance}))
            return {};
    }
    std::set<int> nodes;
    for (std::size_t i = 0; i < paths_from_lamp; ++i) {
        RandomStream random(mix_bits(0x1a39, i));
        Ray ray{lamp.position, sphere_direction(random.next2())};
        float reach = lamp.range;
        if (lamp.kind == LightKind::spot && glm::dot(ray.direction, lamp.direction) <= lamp.cos_outer) {
            // Anywhere in the cone, evenly.
            const float cosine = 1 - random.next() * (1 - lamp.cos_outer);
            const glm::vec3 side = glm::cross(lamp.direction, ray.direction);
            if (!(glm::dot(side, side) > 0)) continue;
            ray.direction = cosine * lamp.direction + std::sqrt(1 - cosine * cosine) * glm::normalize(side);
        }
        for (int bounce = 0; bounce < bounces; ++bounce) {
            const std::optional<Stop> stop = first_stop(tracer, ray.origin, ray.direction, reach);
            if (bounce == 0) nodes.insert(stop ? node_of(scene, tracer, stop->hit.id) : -1);
            if (!stop) break;
            ray = reflected(stop->surface, random);
            if (sees_a_point(ray.origin, random)) return {};
            reach = infinity;
        }
    }
    return ShutOut{fmt::format("the lamp \"{}\"", lamp.name), nodes.size() == 1 ? *nodes.begin() : -1};
}

}  // namespace

std::vector<ShutOut> find_shut_out(const PathTracer& paths, std::span<const glm::vec3> points) {
    std::vector<ShutOut> found;
    const Tracer& tracer = paths.tracer();
    const Scene& scene = tracer.scene();
    if (points.empty() || tracer.triangle_count() == 0) return found;
    const Box around = bounds_of(points);
    const Environment& sky = paths.environment();
    if (paths.estimators().sky) {
        const auto aim = [&](RandomStream& random) -> std::optional<Towards> {
            const glm::vec2 u = random.next2();
            const Environment::Sample sample = sky.sample({random.next(), u.x, u.y});
            if (!(sample.pdf > 0) || sample.radiance == glm::vec3(0)) return {};
            return Towards{sample.direction, infinity};
        };
        if (std::optional<ShutOut> out = shut_out_by(tracer, points, aim, true)) {
            out->light = "the sky";
            found.push_back(std::move(*out));
        }
    }
    std::vector<std::optional<ShutOut>> lamps(scene.lights.size());
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        if (light.kind != LightKind::directional || !shines(paths, i)) continue;
        const auto aim = [&](RandomStream&) { return std::optional(Towards{-light.direction, infinity}); };
        lamps[i] = shut_out_by(tracer, points, aim, false);
        if (lamps[i]) lamps[i]->light = fmt::format("the sun \"{}\"", light.name);
    }
    for_each_index(scene.lights.size(), [&](std::size_t i) {
        const Light& light = scene.lights[i];
        Box place;
        place.extend(light.position);
        if (light.kind == LightKind::directional || !shines(paths, i) || !is_within(place, around)) return;
        lamps[i] = shut_in(tracer, points, light);
    });
    for (std::optional<ShutOut>& lamp : lamps)
        if (lamp) found.push_back(std::move(*lamp));
    return found;
}

bool is_all_shut_out(const PathTracer& paths, std::span<const ShutOut> shut_out) {
    if (paths.estimators().emitters) return false;
    std::size_t shining = paths.estimators().sky ? 1 : 0;
    for (std::size_t i = 0; i < paths.tracer().scene().lights.size(); ++i) shining += shines(paths, i) ? 1 : 0;
    const bool all_by_meshes =
        std::all_of(shut_out.begin(), shut_out.end(), [](const ShutOut& out) { return out.node >= 0; });
    return shining > 0 && shut_out.size() == shining && all_by_meshes;
}

}  // namespace lightgrid
