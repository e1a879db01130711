#pragma once

#include "core/sampling.h"
#include "core/tracer.h"
#include "probes/emitter_tree.h"
#include "probes/light_sources.h"

#include <glm/glm.hpp>

#include <optional>
#include <span>
#include <vector>

namespace lightgrid {

/// All emitting triangles of a level, to be sampled in proportion to about what they bring to a receiver: near ones
/// evenly by solid angle, far ones, where that is nearly the same and costs more, by area. Of triangles of one material
/// that coincide one is sampled for all, so that doubled geometry shines once, and from both sides where they face both
/// ways.
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

    [[nodiscard]] bool empty() const noexcept { return tree_.empty(); }
    [[nodiscard]] std::size_t size() const noexcept { return triangles_.size(); }

    /// For a receiver that many samples are drawn for. Not where there are none to draw.
    [[nodiscard]] EmitterCut open(const Receiver& receiver, std::uint32_t samples) const {
        return tree_.open(receiver, samples);
    }

    /// A point on an emitter, as seen from `receiver`. Both in [0, 1): `pick` chooses the triangle, `where` the place.
    [[nodiscard]] Sample sample(const Receiver& receiver, double pick, glm::vec2 where) const noexcept;
    /// Whether the side of an emitting triangle that a ray met emits.
    [[nodiscard]] bool emits(const Hit& hit, bool front) const noexcept;
    /// Density of `sample` for the point that a ray from `receiver` met, per steradian.
    [[nodiscard]] float pdf(const Receiver& receiver, const Hit& hit, const Surface& surface) const noexcept;

  private:
    struct Triangle {
        SurfaceId id;
        double area;
        bool both_sides;
        std::uint32_t sampled_as;  // index of the one that is sampled for all that coincide
        glm::vec3 center{0};
        float near_squared = 0;  // receivers that are not further away sample it by solid angle
    };

    /// As the receiver sees it; nothing where it is to be sampled by area.
    [[nodiscard]] std::optional<SphericalTriangle> near_triangle(glm::vec3 receiver,
                                                                 const Triangle& triangle) const noexcept;
    void merge_coincident(std::span<double> power);
    [[nodiscard]] std::uint32_t index_of(const SurfaceId& id) const noexcept;
    [[nodiscard]] EmitterTree tree_of(std::span<const double> power) const;

    const Tracer* tracer_;
    std::vector<Triangle> triangles_;
    EmitterTree tree_;
    // Index of the first triangle of a geometry in triangles_, or none: [0] those placed once, [1 + i] instance i.
    std::vector<std::vector<std::uint32_t>> first_;
};

}  // namespace lightgrid
