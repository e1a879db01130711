#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <string>
#include <vector>

/// The result of a bake as plain data. Positions are in the level's own coordinates, metres.
namespace lightgrid {

/// What became of a probe. `absent` pads bricks that reach beyond their grid; it has no light and no place.
enum class ProbeState : std::uint8_t {
    absent = 0,
    valid = 1,    // gathered at its lattice point
    moved = 2,    // gathered beside it: the lattice point is inside or on a surface
    filled = 3,   // invalid: inside something; light taken from valid neighbours
    missing = 4,  // invalid, and no valid neighbour to fill from: no light is known here (which is not black)
};
[[nodiscard]] constexpr bool is_valid(ProbeState state) {
    return state == ProbeState::valid || state == ProbeState::moved;
}

/// A lattice of probes: probe (i, j, k) stands at origin + (i, j, k) * spacing.
struct Grid {
    glm::dvec3 origin{0};
    glm::dvec3 spacing{1};
    glm::ivec3 counts{0};  // probes along each axis, at least 1

    [[nodiscard]] glm::dvec3 position(glm::ivec3 probe) const { return origin + glm::dvec3(probe) * spacing; }
};

/// Bricks hold brick_size^3 probes, x fastest, then y, then z. Those of a grid's neighbour cells are in the next brick.
inline constexpr int brick_size = 4;
inline constexpr int probes_per_brick = brick_size * brick_size * brick_size;

struct Brick {
    int grid = 0;          // index in Volume::grids
    glm::ivec3 origin{0};  // first probe, a multiple of brick_size
};

/// Probes in slots: brick b's probe p is slot b * probes_per_brick + p; a probe list (no cells) uses slot = row.
struct Volume {
    int bands = 3;
    std::vector<Grid> grids;  // empty for a probe list
    std::vector<Brick> bricks;
    std::vector<glm::dvec3> list;  // positions of a probe list, in the caller's order; empty for grids

    std::vector<ProbeState> states;        // per slot
    std::vector<glm::vec3> coefficients;   // per slot bands^2: radiance, cd/m^2 sr^(1/2)
    std::vector<glm::vec3> errors;         // standard errors of them
    std::vector<glm::vec3> axis_errors;    // per slot 6: standard error of the irradiance along +x -x +y -y +z -z
    std::vector<glm::vec3> offsets;        // per slot: where light was gathered, minus the lattice point; empty: none moved
    bool half = false;                     // coefficients are stored in the file as half, scaled per brick
    std::map<std::string, std::string> settings;  // written to the header as they are: level, seed, samples, version ...

    [[nodiscard]] bool has_cells() const { return !grids.empty(); }
    [[nodiscard]] std::size_t slots() const { return states.size(); }
    [[nodiscard]] std::span<const glm::vec3> sh(std::size_t slot) const {
        const std::size_t n = static_cast<std::size_t>(bands) * bands;
        return std::span(coefficients).subspan(slot * n, n);
    }
};

/// A volume of these grids with every brick allocated, all probes `valid`, padding `absent`, light and errors zero.
[[nodiscard]] Volume make_volume(std::vector<Grid> grids, int bands);
/// A probe list with light and errors zero.
[[nodiscard]] Volume make_probe_list(std::vector<glm::dvec3> positions, int bands);

/// Where the probe in `slot` was gathered.
[[nodiscard]] glm::dvec3 gather_position(const Volume& volume, std::size_t slot);
/// Its place in the lattice (or the list).
[[nodiscard]] glm::dvec3 lattice_position(const Volume& volume, std::size_t slot);

}  // namespace lightgrid
