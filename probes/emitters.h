#pragma once

#include "core/sampling.h"
#include "core/tracer.h"
#include "probes/emitter_tree.h"
#include "probes/light_sources.h"
#include "probes/lit_parts.h"

#include <glm/glm.hpp>

#include <optional>
#include <span>
#include <vector>

namespace lightgrid {

/// All emitting triangles of a level, to be sampled in proportion to about what they bring to a receiver: near ones
/// evenly by solid angle, far ones, where that is nearly the same and costs more, by area. Where textures make a
/// triangle emit here and not there, the parts of it that do are sampled in its place. Of triangles of one material that
/// coincide one is sampled for all, so that doubled geometry shines once, and from both sides where they face both ways.
class Emitters {
  public:
    struct Sample {
        SurfaceId id;
        glm::vec3 position{0};  // off the surface, on the emitting side that the receiver sees
        glm::vec3 radiance{0};  // towards the receiver; 0 where it sees a dark side
        float pdf = 0;          // per steradian at the receiver
    };

    /// sources  materials that are off there do not emit
    explicit Emitters(const Tracer& tracer, const LightSources& sources = {});

    /// Nothing emits: not for want of finding it, but for certain.
    [[nodiscard]] bool empty() const noexcept { return tree_.empty(); }
    /// Triangles of emissive materials, and parts of them.
    [[nodiscard]] std::size_t size() const noexcept { return triangles_.size(); }

    /// For a receiver that many samples are drawn for. Not where there are none to draw.
    [[nodiscard]] EmitterCut open(const Receiver& receiver, std::uint32_t samples) const {
        return tree_.open(receiver, samples);
    }

    /// A point on an emitter, as seen from `receiver`. Both in [0, 1): `pick` chooses the triangle or part, `where` the
    /// place.
    [[nodiscard]] Sample sample(const Receiver& receiver, double pick, glm::vec2 where) const noexcept;
    /// Whether the side of an emitting triangle that a ray met emits.
    [[nodiscard]] bool emits(const Hit& hit, bool front) const noexcept;
    /// Density of `sample` for the point that a ray from `receiver` met, per steradian; 0 where it is never sampled.
    [[nodiscard]] float pdf(const Receiver& receiver, const Hit& hit, const Surface& surface) const noexcept;

  private:
    static constexpr std::uint32_t none = 0xffffffffU;

    /// A triangle of the level, or a part of one.
    struct Triangle {
        SurfaceId id;
        double area;
        bool both_sides;
        std::uint32_t sampled_as;  // index of the one that is sampled for all that coincide
        glm::vec3 center{0};
        float near_squared = 0;           // receivers that are not further away sample it by solid angle
        std::uint32_t part = none;        // which of lit_ it is
        std::uint32_t root = none;        // of a triangle that is divided: in lit_
        std::uint32_t first_part = none;  // its parts from here on in triangles_
    };

    void add_parts(std::vector<double>& power);
    [[nodiscard]] Tracer::Corners corners(const Triangle& triangle) const noexcept;
    [[nodiscard]] glm::vec2 on_triangle(const Triangle& triangle, glm::vec2 barycentric) const noexcept;
    /// As the receiver sees it; nothing where it is to be sampled by area.
    [[nodiscard]] std::optional<SphericalTriangle> near_triangle(glm::vec3 receiver,
                                                                 const Triangle& triangle) const noexcept;
    void merge_coincident(std::span<double> power);
    [[nodiscard]] std::uint32_t index_of(const SurfaceId& id) const noexcept;
    /// What is sampled of the place that a ray met; none where nothing is.
    [[nodiscard]] std::uint32_t sampled_at(const Hit& hit) const noexcept;
    [[nodiscard]] EmitterTree tree_of(std::span<const double> power) const;

    const Tracer* tracer_;
    LitParts lit_;
    std::vector<Triangle> triangles_;  // as the level has them; then the parts of those that are divided
    EmitterTree tree_;
    // Index of the first triangle of a geometry in triangles_, or none: [0] those placed once, [1 + i] instance i.
    std::vector<std::vector<std::uint32_t>> first_;
};

}  // namespace lightgrid
