#pragma once

#include "core/tracer.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

/// The level's surfaces in pieces that may share one value of light.
namespace lightgrid {

/// A point of a surface and which of its sides is meant.
struct SurfaceSide {
    SurfaceId id;
    glm::vec3 position{0};
    glm::vec3 normal{0};  // any length, out of the side

    /// The side that a ray met.
    SurfaceSide(const Hit& hit, glm::vec3 origin, glm::vec3 direction);
};

/// A patch is what lies within one cube of a lattice, of one mesh, faces about the same way, and sees itself: cubes
/// that something cuts in two (a wall on a floor) hold several patches, told apart by whether they see a point of it.
///
/// Cubes of level k are 2^k times as wide as those of level 0. A point belongs to a patch of the finest level that has
/// one for it.
class SurfacePatches {
  public:
    static constexpr std::uint32_t none = 0xffffffffU;
    static constexpr int most_levels = 16;

    /// width  of the cubes of level 0, metres, > 0
    explicit SurfacePatches(float width);

    [[nodiscard]] std::uint32_t size() const noexcept { return static_cast<std::uint32_t>(patches_.size()); }
    [[nodiscard]] std::uint32_t cut_cubes() const noexcept { return cut_cubes_; }

    /// Or none. Counts the shadow rays that it takes (in cubes with several patches only).
    [[nodiscard]] std::uint32_t find(const Tracer& tracer, const SurfaceSide& side,
                                     std::uint64_t& shadow_rays) const noexcept;

    /// Finds or makes a patch of a level for each of the sides; none where a cube is full. Patches are numbered by the
    /// first of their sides.
    [[nodiscard]] std::vector<std::uint32_t> add(const Tracer& tracer, std::span<const SurfaceSide> sides, int level,
                                                 std::uint64_t& shadow_rays);

  private:
    static constexpr int most_patches_per_cube = 4;

    /// Of the hash table. As small as can be: gathers read little else, and at random.
    struct Slot {
        std::uint32_t tag = 0;         // the upper half of the key; the lower one says where to look
        std::uint32_t first : 31 = 0;  // patch + 1; 0: the slot is free
        std::uint32_t cut : 1 = 0;     // see whether it sees the point
    };
    struct Patch {
        std::uint64_t key = 0;      // of its cube
        glm::vec3 anchor{0};        // a point of it, lifted off the surface
        std::uint32_t next = none;  // patch of the same cube
    };

    [[nodiscard]] std::uint64_t key_of(const SurfaceSide& side, int level) const noexcept;
    /// Of the key, or where it would be.
    [[nodiscard]] std::size_t slot_of(std::uint64_t key) const noexcept;
    void grow_table();
    [[nodiscard]] glm::vec3 lifted(const SurfaceSide& side, int level) const noexcept;
    [[nodiscard]] bool is_cut(const Tracer& tracer, const SurfaceSide& side, int level,
                              std::uint64_t& shadow_rays) const noexcept;

    std::array<float, most_levels> widths_;
    std::array<float, most_levels> inverse_widths_;
    int levels_ = 0;
    std::vector<Slot> slots_;  // a power of two, at most half full
    std::uint32_t used_slots_ = 0;
    std::uint32_t cut_cubes_ = 0;
    std::vector<Patch> patches_;
};

}  // namespace lightgrid
