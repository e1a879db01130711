#pragma once

#include "core/sampling.h"
#include "core/tracer.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace lightgrid {

/// All emitting triangles of a level, to be sampled in proportion to their power. Of triangles of one material that
/// coincide one is sampled for all, so that doubled geometry shines once, and from both sides where they face both
/// ways.
class Emitters {
  public:
    struct Sample {
        SurfaceId id;
        glm::vec3 position{0};  // off the surface, on the emitting side that the receiver sees
        glm::vec3 radiance{0};  // towards the receiver; 0 where it sees a dark side
        float pdf = 0;          // per steradian at the receiver
    };

    explicit Emitters(const Tracer& tracer);

    [[nodiscard]] bool empty() const noexcept { return table_.empty(); }
    [[nodiscard]] std::size_t size() const noexcept { return triangles_.size(); }

    /// A point on an emitter, as seen from `receiver`. Both in [0, 1): `pick` chooses the triangle, `where` the place.
    [[nodiscard]] Sample sample(glm::vec3 receiver, double pick, glm::vec2 where) const noexcept;
    /// Whether the side of an emitting triangle that a ray met emits.
    [[nodiscard]] bool emits(const Hit& hit, bool front) const noexcept;
    /// Density of `sample` for the point that a ray from `receiver` met, per steradian.
    [[nodiscard]] float pdf(glm::vec3 receiver, const Hit& hit, const Surface& surface) const noexcept;

  private:
    struct Triangle {
        SurfaceId id;
        double area;
        bool both_sides;
        std::uint32_t sampled_as;  // index of the one that is sampled for all that coincide
    };

    void merge_coincident(std::span<double> power);
    [[nodiscard]] std::uint32_t index_of(const SurfaceId& id) const noexcept;
    [[nodiscard]] float pdf_by_area(std::uint32_t index) const noexcept;

    const Tracer* tracer_;
    std::vector<Triangle> triangles_;
    AliasTable table_;
    // Index of the first triangle of a geometry in triangles_, or none: [0] those placed once, [1 + i] instance i.
    std::vector<std::vector<std::uint32_t>> first_;
};

}  // namespace lightgrid
