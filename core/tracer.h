#pragma once

#include "core/scene.h"

#include <glm/glm.hpp>

#include <compare>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

/// Rays against the level, relative to Scene::origin. The one place that knows Embree is tracer.cpp.
namespace lightgrid {

/// A triangle of the level: which instance (or none), which geometry in it, which primitive.
struct SurfaceId {
    static constexpr std::uint32_t none = 0xffffffffU;
    std::uint32_t instance = none;
    std::uint32_t geometry = none;
    std::uint32_t triangle = none;

    auto operator<=>(const SurfaceId&) const = default;
};

/// What the ray met first.
struct Hit {
    SurfaceId id;
    float distance = std::numeric_limits<float>::infinity();
    glm::vec2 barycentric{0};
    glm::vec3 normal{0};  // of the triangle, in the level; any length, out of either side

    [[nodiscard]] bool found() const { return id.geometry != SurfaceId::none; }
};

/// Geometry of the point that was hit.
struct Surface {
    const Mesh* mesh = nullptr;
    glm::vec3 position{0};  // on the triangle's plane to half a unit in the last place: interpolated in double
    glm::vec3 normal{0};    // geometric, unit length, out of the front (counter-clockwise) side
    bool front = false;     // the ray came from the front side
    float offset = 0;       // how far off the plane a new ray starts, so that rounding cannot make it meet the triangle

    /// Where a ray that leaves on the side that `direction` points to starts.
    [[nodiscard]] glm::vec3 leave(glm::vec3 direction) const {
        return position + (glm::dot(direction, normal) >= 0 ? offset : -offset) * normal;
    }
};

/// Immutable; any number of threads may trace at once. Callers run with denormals flushed (for_each_index does).
class Tracer {
  public:
    /// Keeps a reference: the scene must outlive it and stay as it is. Throws Error (Fault::work) where Embree fails.
    explicit Tracer(const Scene& scene);
    ~Tracer();
    Tracer(Tracer&&) noexcept;
    Tracer& operator=(Tracer&&) noexcept;
    Tracer(const Tracer&) = delete;
    Tracer& operator=(const Tracer&) = delete;

    [[nodiscard]] const Scene& scene() const noexcept;
    [[nodiscard]] std::size_t triangle_count() const noexcept;  // instances counted each

    /// First surface along the ray that MASK does not cut away. BLEND and transmitting surfaces are hits: what passes
    /// them is for the caller to decide, who goes on with `behind`. A surface that the origin is exactly on is not met.
    ///
    /// direction  any length but 0; distances are in units of it
    /// behind     an earlier hit of the same ray, on a surface that passes light: only what comes after it is found.
    ///            Coincident surfaces that pass light come one after the other, by SurfaceId.
    [[nodiscard]] Hit closest_hit(glm::vec3 origin, glm::vec3 direction,
                                  float max_distance = std::numeric_limits<float>::infinity(),
                                  const Hit& behind = {}) const noexcept;

    [[nodiscard]] Surface surface(const Hit& hit, glm::vec3 direction) const noexcept;

    /// Share of light, by colour, that gets from `origin` to origin + max_distance * direction: 0 behind an opaque
    /// surface, the product of what BLEND and transmission let pass else.
    [[nodiscard]] glm::vec3 transmittance(glm::vec3 origin, glm::vec3 direction, float max_distance) const noexcept;

    /// The same of many rays from one point, which share their way through the level's tree: a fifth less time than one
    /// by one, a third where shadow rays go about the same way.
    void closest_hits(glm::vec3 origin, std::span<const glm::vec3> directions, std::span<Hit> hits) const noexcept;
    struct Way {
        glm::vec3 direction{0};  // any length but 0
        float max_distance = 0;  // in units of it
    };
    void transmittances(glm::vec3 origin, std::span<const Way> ways, std::span<glm::vec3> shares) const noexcept;

    /// Corners of a triangle, relative to Scene::origin, in winding order as stored; `mirrored` instances are
    /// clockwise.
    struct Corners {
        glm::dvec3 a, b, c;
        bool mirrored;
    };
    [[nodiscard]] Corners corners(SurfaceId id) const noexcept;
    [[nodiscard]] const Mesh& mesh(SurfaceId id) const noexcept;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// What a surface does to light that meets it: shares by colour that pass straight on and that are reflected.
/// BLEND: reflects times alpha, passes 1 - alpha untinted; transmission t: reflects times 1 - t, passes t x base
/// colour.
[[nodiscard]] inline glm::vec3 passed_share(const SurfacePoint& point) {
    return glm::vec3(1 - point.alpha) + point.alpha * point.transmission * point.tint;
}
[[nodiscard]] inline glm::vec3 reflected_share(const SurfacePoint& point) {
    return point.alpha * (1 - point.transmission) * point.albedo;
}

}  // namespace lightgrid
