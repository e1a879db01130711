#include "viewer/transfer.h"

#include "core/parallel.h"
#include "core/sampling.h"
#include "core/sh.h"
#include "core/tracer.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>

namespace lightgrid {
namespace {

constexpr std::size_t most_shown_rays = 16'000'000;
constexpr std::size_t least_shown_samples = 16;
constexpr std::size_t most_shown_samples = 128;

/// How far from a vertex its rays start, as a share of the edges around it: above its surface, and as far into it, so
/// that a surface that meets it there is met. In multiples of the object's size at least, for rounding's sake.
constexpr float start_in_edges = 0.01F;
constexpr float least_start = 1e-6F;

/// Where the rays of each vertex start.
///
/// What stands at the vertex itself must be on the right side of the start: a floor's vertex at the foot of a wall
/// starts on the floor. Steps along the surface are in the plane across the normal: an object that is convex there
/// stays below it.
std::vector<glm::vec3> ray_starts(const ObjectMesh& object) {
    struct Around {
        glm::vec3 inward{0};
        float edges = 0;
        int count = 0;
    };
    std::vector<Around> around(object.positions.size());
    Box bounds;
    for (const glm::vec3& position : object.positions) bounds.extend(position);
    for (const glm::uvec3& triangle : object.triangles) {
        for (int k = 0; k < 3; ++k) {
            const glm::vec3 a = object.positions[triangle[(k + 1) % 3]] - object.positions[triangle[k]];
            const glm::vec3 b = object.positions[triangle[(k + 2) % 3]] - object.positions[triangle[k]];
            const glm::vec3 middle = a + b;
            const float length = glm::length(middle);
            Around& here = around[triangle[k]];
            if (length > 0) here.inward += middle / length;
            here.edges += 0.5F * (glm::length(a) + glm::length(b));
            ++here.count;
        }
    }
    const float least = least_start * static_cast<float>(glm::length(bounds.size()));
    std::vector<glm::vec3> starts;
    for (std::size_t i = 0; i < around.size(); ++i) {
        const Around& here = around[i];
        const float count = static_cast<float>(std::max(here.count, 1));
        const float step = std::max(start_in_edges * here.edges / count, least);
        const glm::vec3 normal = object.normals[i];
        const glm::vec3 across = (here.inward - glm::dot(here.inward, normal) * normal) / count;
        starts.push_back(object.positions[i] + step * (normal + across));
    }
    return starts;
}

/// Rays from all vertices, the same whenever they are asked for.
class Rays {
  public:
    Rays(const ObjectMesh& object, const Tracer& tracer)
        : object_(object), tracer_(tracer), starts_(ray_starts(object)) {}

    /// Calls found(direction, hit) for each of `count` rays of a vertex that the object stops. Directions are spread by
    /// the cosine.
    template <typename Found>
    void trace(std::size_t vertex, std::uint32_t count, Found found) const {
        for (std::uint32_t i = 0; i < count; ++i) {
            const glm::vec3 direction = cosine_direction(object_.normals[vertex], sobol_point(i, mix_bits(0, vertex)));
            const Hit hit = tracer_.closest_hit(starts_[vertex], direction);
            if (hit.found()) found(direction, hit);
        }
    }

  private:
    const ObjectMesh& object_;
    const Tracer& tracer_;
    std::vector<glm::vec3> starts_;
};

}  // namespace

std::vector<float> unshadowed_transfer(std::span<const glm::vec3> normals, int bands) {
    const auto size = static_cast<std::size_t>(sh_size(bands));
    std::vector<float> transfer(normals.size() * size);
    for (std::size_t v = 0; v < normals.size(); ++v) {
        const std::span values = std::span(transfer).subspan(v * size, size);
        sh_basis(bands, normals[v], values);
        for (int l = 0; l < bands; ++l) {
            for (int m = -l; m <= l; ++m) values[sh_index(l, m)] *= static_cast<float>(cosine_lobe(l));
        }
    }
    return transfer;
}

TransferOptions shown_transfer(const ObjectMesh& object) {
    const std::size_t vertices = std::max<std::size_t>(object.positions.size(), 1);
    const std::size_t samples = std::clamp(most_shown_rays / vertices, least_shown_samples, most_shown_samples);
    return {.samples = static_cast<std::uint32_t>(std::bit_floor(samples))};
}

std::vector<float> self_shadowed_transfer(const ObjectMesh& object, const TransferOptions& options) {
    const auto size = static_cast<std::size_t>(sh_size(options.bands));
    const Scene scene = scene_from_object(object);
    const Tracer tracer(scene);
    const Rays rays(object, tracer);
    std::vector<float> direct = unshadowed_transfer(object.normals, options.bands);
    for_each_index(object.positions.size(), [&](std::size_t v) {
        std::vector<float> basis(size);
        std::vector<double> hidden(size, 0);
        if (options.step) options.step();
        rays.trace(v, options.samples, [&](glm::vec3 direction, const Hit&) {
            sh_basis(options.bands, direction, std::span(basis));
            for (std::size_t i = 0; i < size; ++i) hidden[i] += static_cast<double>(basis[i]);
        });
        for (std::size_t i = 0; i < size; ++i) {
            direct[v * size + i] -= static_cast<float>(glm::pi<double>() / options.samples * hidden[i]);
        }
    });
    if (!options.bounce) return direct;

    // A surface of albedo a shows radiance a E / pi; over cosine-spread rays, E = pi times the mean of that.
    std::vector<float> transfer = direct;
    for_each_index(object.positions.size(), [&](std::size_t v) {
        std::vector<double> reflected(size, 0);
        if (options.step) options.step();
        rays.trace(v, options.samples, [&](glm::vec3 direction, const Hit& hit) {
            if (!tracer.surface(hit, direction).front) return;  // light behind a surface is not known
            const ObjectDraw& draw = object.draws[hit.id.geometry];
            const glm::uvec3 corners = object.triangles[draw.first_triangle + hit.id.triangle];
            const glm::vec2 b = hit.barycentric;
            const glm::vec3 weights = luminance(surface_at(scene, tracer.mesh(hit.id), hit.id.triangle, b).albedo) *
                                      glm::vec3(1 - b.x - b.y, b.x, b.y);
            for (int k = 0; k < 3; ++k) {
                const float* const there = &direct[corners[k] * size];
                for (std::size_t i = 0; i < size; ++i) {
                    reflected[i] += static_cast<double>(weights[k]) * static_cast<double>(there[i]);
                }
            }
        });
        for (std::size_t i = 0; i < size; ++i) {
            transfer[v * size + i] += static_cast<float>(reflected[i] / options.samples);
        }
    });
    return transfer;
}

void light_vertices(std::span<const float> transfer, std::span<const glm::vec3> radiance,
                    std::span<glm::vec3> irradiance) noexcept {
    const std::size_t size = radiance.size();
    assert(transfer.size() == size * irradiance.size());
    for (std::size_t v = 0; v < irradiance.size(); ++v) {
        glm::vec3 sum(0);
        for (std::size_t i = 0; i < size; ++i) sum += transfer[v * size + i] * radiance[i];
        irradiance[v] = sum;
    }
}

}  // namespace lightgrid
