#pragma once

#include "probes/known_cells.h"
#include "probes/volume.h"

#include <glm/glm.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lightgrid {

enum class Outside : std::uint8_t { clamp, fade };  // where no light is known: the nearest, or fade to `environment`
enum class Interpolation : std::uint8_t { trilinear, nearest };  // of a cell's corners: all, or the one that says most

struct SampleOptions {
    float normal_bias = 0;  // that the position is moved along the normal before the look-up; lengths are as in Volume
    Outside outside = Outside::clamp;
    float fade_distance = 1;                   // from the nearest light at which `fade` ends in the environment
    std::span<const glm::vec3> environment{};  // bands^2 coefficients; empty: black
    Interpolation interpolation = Interpolation::trilinear;
    std::span<const glm::vec3> layers{};  // weight times colour of each of the volume's; empty: the combined light
};

/// Interpolated coefficients. weight: the share of trilinear weight that valid corners carried, before renormalisation
/// (with `fade`, the environment counts as valid). 0: no valid corner; sh then is the light of `filled` corners, and
/// all zero where no cell of the volume knows light (known_cells.h): unknown, not black.
struct Sample {
    std::vector<glm::vec3> sh;
    float weight = 0;
};

/// Finds cells in a volume quickly. Keeps a reference: the volume must outlive it and stay as it is. Any number of
/// threads may sample at once.
///
/// The light at a position is interpolated trilinearly between the corners of its cell, with weights renormalised over
/// the valid ones, so that at a valid probe's lattice point it is the probe's own, to the bit. Where grids overlap, the
/// finest spacing that knows an answer gives it: first of all from valid corners, then from filled ones. A cell is a
/// grid's own if all corners that carry weight are stored.
///
/// Where no grid answers, outside of all of them, or where bricks are not stored or probes are missing, the nearest point
/// answers that belongs to a cell which knows light (known_cells.h), so that light stays what it is on the way out. If
/// those of the cell's corners that answer carry no weight at that point, being all on other faces, the point is moved
/// into the cell by border_share of its size. `fade` counts its distance from the nearest point.
///
/// `Interpolation::nearest` takes that corner alone which would have weighed most of those that answer: the cheapest
/// look-up, and the light then jumps half-way between probes.
class Sampler {
  public:
    /// Throws Error for a probe list, which has no cells.
    explicit Sampler(const Volume& volume);

    [[nodiscard]] Sample sample(glm::dvec3 position, const SampleOptions& options = {}) const;
    /// The same into bands^2 coefficients of the caller's; returns the weight. Allocates nothing.
    float sample(glm::dvec3 position, std::span<glm::vec3> sh, const SampleOptions& options = {}) const noexcept;
    /// A batch: bands^2 coefficients and one weight for each position. Allocates nothing.
    void sample(std::span<const glm::dvec3> positions, std::span<glm::vec3> sh, std::span<float> weights,
                const SampleOptions& options = {}) const noexcept;

    /// Irradiance, lux; not clamped at zero. Zero where no light is known. Allocates nothing.
    [[nodiscard]] glm::vec3 irradiance(glm::dvec3 position, glm::vec3 normal,
                                       const SampleOptions& options = {}) const noexcept;
    /// A batch: as many results as there are positions and normals.
    void irradiance(std::span<const glm::dvec3> positions, std::span<const glm::vec3> normals,
                    std::span<glm::vec3> results, const SampleOptions& options = {}) const noexcept;

    /// Which probes answer at a position, and how much each says: the weights of corners and environment sum to 1, or
    /// there is no corner.
    struct Corners {
        int count = 0;
        std::array<std::size_t, 8> slots;  // of `count` corners; the rest is not written
        std::array<float, 8> weights;
        float known = 0;        // Sample::weight
        float environment = 0;  // share of the environment
    };
    [[nodiscard]] Corners corners(glm::dvec3 position, const SampleOptions& options = {}) const noexcept;

  private:
    [[nodiscard]] Corners corners_within(glm::dvec3 position, Interpolation interpolation) const noexcept;
    [[nodiscard]] Corners answer(std::size_t grid, glm::ivec3 lower, glm::dvec3 share,
                                 Interpolation interpolation) const noexcept;
    [[nodiscard]] Corners cell_corners(std::size_t grid, glm::ivec3 lower, glm::dvec3 share) const noexcept;
    [[nodiscard]] Corners nearest_corner(std::size_t grid, glm::ivec3 lower, glm::dvec3 share) const noexcept;
    void interpolate(const Corners& from, const SampleOptions& options, std::span<glm::vec3> sh) const noexcept;

    const Volume& volume_;
    SlotTable slots_;
    std::vector<std::size_t> grids_;  // finest first
    KnownCells known_;
};

}  // namespace lightgrid
