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
#include <mutex>
#include <optional>
#include <set>

namespace lightgrid {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr int bounces = 4;
constexpr std::size_t paths_from_points = 4096;
constexpr std::size_t paths_from_lamp = 512;
constexpr int points_tried = 4;  // at each vertex of a lamp's path
constexpr int most_layers = 64;  // along a ray

/// A direction towards a light, and how far it is free to go; none: nothing comes from there.
struct Towards {
    glm::vec3 direction{0};
    float distance = 0;
};

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

Box bounds_of_node(const Scene& scene, int node) {
    Box box;
    for (const int mesh : scene.placed) {
        if (scene.meshes[mesh].node != node) continue;
        for (const glm::vec3& position : scene.meshes[mesh].positions) box.extend(position);
    }
    for (const Instance& instance : scene.instances) {
        if (instance.node != node) continue;
        for (const int mesh : scene.models[instance.model].meshes)
            for (const glm::vec3& position : scene.meshes[mesh].positions)
                box.extend(instance.to_level * glm::vec4(position, 1));
    }
    return box;
}

Box bounds_of_points(std::span<const glm::vec3> points) {
    Box box;
    for (const glm::vec3& point : points) box.extend(point);
    return box;
}

bool is_within(const Box& inner, const Box& outer) {
    const glm::dvec3 slack = 0.01 * outer.size();  // grids may reach a little beyond what they are for
    return glm::all(glm::greaterThanEqual(inner.min, outer.min - slack)) &&
           glm::all(glm::lessThanEqual(inner.max, outer.max + slack));
}

std::string name_of_node(const Scene& scene, int node) {
    return node < 0 ? std::string() : scene.node_names[static_cast<std::size_t>(node)];
}

/// The mesh that alone keeps a light at infinity from all points; empty: light arrives, or no one mesh does.
///
/// aim  draws a direction to the light
std::string mesh_before(const Tracer& tracer, std::span<const glm::vec3> points, const Box& around,
                        const std::function<std::optional<Towards>(RandomStream&)>& aim, bool only_upwards) {
    const Scene& scene = tracer.scene();
    std::atomic<bool> arrives = false;
    std::mutex lock;
    std::size_t rays = 0;
    std::map<int, std::size_t> stopped;  // rays that a node stops,
    std::set<int> alone;                 // and nodes that stop some by themselves
    for_each_index(paths_from_points, [&](std::size_t i) {
        if (arrives) return;
        RandomStream random(mix_bits(0x5107, i));
        glm::vec3 at = points[i * points.size() / paths_from_points];
        glm::vec3 direction = sphere_direction(random.next2());
        for (int bounce = 0; bounce < bounces; ++bounce) {
            if (const std::optional<Towards> towards = aim(random)) {
                if (is_free(tracer, at, *towards)) {
                    arrives = true;
                    return;
                }
                if (bounce == 0 && (!only_upwards || towards->direction.y > 0)) {
                    const std::set<int> nodes = nodes_in_the_way(tracer, at, towards->direction);
                    const std::scoped_lock locked(lock);
                    ++rays;
                    for (const int node : nodes) ++stopped[node];
                    if (nodes.size() == 1) alone.insert(*nodes.begin());
                }
            }
            const std::optional<Stop> stop = first_stop(tracer, at, direction);
            if (!stop) return;
            const Ray ray = reflected(stop->surface, random);
            at = ray.origin;
            direction = ray.direction;
        }
    });
    if (arrives) return {};
    for (const int node : alone)
        if (stopped[node] == rays && is_within(around, bounds_of_node(scene, node))) return name_of_node(scene, node);
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
    return ShutOut{fmt::format("the lamp \"{}\"", lamp.name),
                   nodes.size() == 1 ? name_of_node(scene, *nodes.begin()) : ""};
}

}  // namespace

std::vector<ShutOut> find_shut_out(const PathTracer& paths, std::span<const glm::vec3> points) {
    std::vector<ShutOut> found;
    const Tracer& tracer = paths.tracer();
    const Scene& scene = tracer.scene();
    if (points.empty() || tracer.triangle_count() == 0) return found;
    const Box around = bounds_of_points(points);
    const Environment& sky = paths.environment();
    if (!sky.is_black()) {
        const auto aim = [&](RandomStream& random) -> std::optional<Towards> {
            const glm::vec2 u = random.next2();
            const Environment::Sample sample = sky.sample({random.next(), u.x, u.y});
            if (!(sample.pdf > 0) || sample.radiance == glm::vec3(0)) return {};
            return Towards{sample.direction, infinity};
        };
        const std::string mesh = mesh_before(tracer, points, around, aim, true);
        if (!mesh.empty()) found.push_back({"the sky", mesh});
    }
    std::vector<std::optional<ShutOut>> lamps(scene.lights.size());
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        if (light.kind != LightKind::directional) continue;
        const auto aim = [&](RandomStream&) { return std::optional(Towards{-light.direction, infinity}); };
        const std::string mesh = mesh_before(tracer, points, around, aim, false);
        if (!mesh.empty()) lamps[i] = ShutOut{fmt::format("the sun \"{}\"", light.name), mesh};
    }
    for_each_index(scene.lights.size(), [&](std::size_t i) {
        const Light& light = scene.lights[i];
        Box place;
        place.extend(light.position);
        if (light.kind != LightKind::directional && is_within(place, around)) lamps[i] = shut_in(tracer, points, light);
    });
    for (std::optional<ShutOut>& lamp : lamps)
        if (lamp) found.push_back(std::move(*lamp));
    return found;
}

}  // namespace lightgrid
