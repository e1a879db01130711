#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The result of a bake as plain data. Lengths and positions are in the level's own coordinates: metres, as glTF says.
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

/// Indices of grids by their widest spacing, axes with a single probe aside, the finest first: the order in which they
/// are asked for light. Grids of the same spacing keep their order.
[[nodiscard]] std::vector<std::size_t> finest_first(std::span<const Grid> grids);

/// Bricks hold brick_size^3 probes, x fastest, then y, then z. Those of a grid's neighbour cells are in the next brick.
inline constexpr int brick_size = 4;
inline constexpr int probes_per_brick = brick_size * brick_size * brick_size;

/// The most bricks that the grids of a volume may span together, stored or not: look-up tables hold 4 bytes for each
/// (256 MiB at most).
inline constexpr std::int64_t max_lattice_bricks = std::int64_t{1} << 26;

struct Brick {
    int grid = 0;          // index in Volume::grids
    glm::ivec3 origin{0};  // first probe, a multiple of brick_size
};

/// The name of Volume::coefficients among layers.
inline constexpr const char* combined_layer = "combined";

/// A part of the light, stored apart so that the run time mixes parts anew (mix_layers, SampleOptions::layers).
struct Layer {
    std::string name;
    std::vector<glm::vec3> coefficients;  // as Volume::coefficients
    double noise = 0;  // standard error of its irradiance over all gathered probes and directions, relative RMS
};

/// Probes in slots: brick b's probe p is slot b * probes_per_brick + p; behind those of the bricks come the rows of the
/// list. A volume has grids, or a list (a "probe list", which has no cells), or both.
struct Volume {
    int bands = 3;
    std::vector<Grid> grids;
    std::vector<Brick> bricks;
    std::vector<glm::dvec3> list;  // places of single probes, in the caller's order

    std::vector<ProbeState> states;       // per slot
    std::vector<glm::vec3> coefficients;  // per slot bands^2: radiance, cd/m^2 sr^(1/2)
    std::vector<glm::vec3> errors;        // standard errors of them
    std::vector<glm::vec3> axis_errors;   // per slot 6: standard error of the irradiance along axis_normals
    std::vector<glm::vec3> offsets;       // per slot: gather position minus lattice point; empty: none moved
    std::vector<Layer> layers;            // parts of the light besides all of it together
    bool half = false;                    // stored in the file as half, scaled per brick (half_storage.h)
    std::map<std::string, std::string>
        settings;  // written to the header as they are: level, seed, samples, version ...

    [[nodiscard]] bool has_cells() const { return !grids.empty(); }
    [[nodiscard]] std::size_t slots() const { return states.size(); }
    /// The slot of the list's first row.
    [[nodiscard]] std::size_t list_start() const { return bricks.size() * probes_per_brick; }
    [[nodiscard]] std::size_t sh_size() const { return static_cast<std::size_t>(bands) * bands; }
    [[nodiscard]] std::span<const glm::vec3> sh(std::size_t slot) const {
        return std::span(coefficients).subspan(slot * sh_size(), sh_size());
    }
};

/// The six directions of Volume::axis_errors, in its order.
inline constexpr std::array<glm::vec3, 6> axis_normals{
    {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};

/// A volume of these grids with every brick allocated (by grid, then z, y, x), and of these single probes; all probes
/// `valid`, padding `absent`, light and errors zero. Throws Error for a grid that check_volume would refuse, before
/// anything is allocated.
[[nodiscard]] Volume make_volume(std::vector<Grid> grids, int bands, std::vector<glm::dvec3> list = {});
/// The same with these bricks only, in their order.
[[nodiscard]] Volume make_volume(std::vector<Grid> grids, std::vector<Brick> bricks, int bands,
                                 std::vector<glm::dvec3> list = {});
/// The same without grids.
[[nodiscard]] Volume make_probe_list(std::vector<glm::dvec3> positions, int bands);

/// Room for other bands; all light becomes zero.
void set_bands(Volume& volume, int bands);

/// Adds grids and bricks of `more`, which has the bands, the layers and, first, the grids of `volume`, and no list.
/// Slots of a list move to the new end.
void append(Volume& volume, const Volume& more);

/// Throws Error that names the first thing wrong: a size that does not fit the others, a brick outside its grid or
/// stored twice, a probe inside its grid that is `absent` or one outside that is not, a number that is not finite, a
/// negative standard error. What save_volume writes and load_volume returns has passed it.
void check_volume(const Volume& volume);

/// The index of a layer, if there is one of that name.
[[nodiscard]] std::optional<std::size_t> find_layer(const Volume& volume, std::string_view name) noexcept;

/// A sky that can be changed is nine layers, sky.0 to sky.8: the light that a sky of radiance Y_i(direction) brings.
/// With the coefficients of a sky's radiance as weights they are the light of that sky, but for what of it is above
/// band 2.
inline constexpr int sky_layer_bands = 3;
[[nodiscard]] std::string sky_layer(int i);
[[nodiscard]] bool has_sky_layers(const Volume& volume) noexcept;
/// Sets the weights of these layers, where a volume has them.
///
/// radiance  of the sky, at least nine coefficients
/// weights   one for each layer of the volume
void set_sky(const Volume& volume, std::span<const glm::vec3> radiance, std::span<glm::vec3> weights);

/// Bytes that coefficients take in the file before they are compressed: without bands that are black, and without
/// colour where there is none.
[[nodiscard]] std::size_t stored_bytes(const Volume& volume, std::span<const glm::vec3> coefficients) noexcept;

/// The light that layers make together, as Volume::coefficients: the sum of each times its weight, colour by colour.
///
/// weights  one for each layer of the volume; any sign
[[nodiscard]] std::vector<glm::vec3> mix_layers(const Volume& volume, std::span<const glm::vec3> weights);

/// Bricks that a grid spans along each axis, stored or not.
[[nodiscard]] inline glm::ivec3 lattice_bricks(const Grid& grid) {
    return (grid.counts - 1) / brick_size + 1;
}

/// Probe p of a brick, relative to the brick's first.
[[nodiscard]] constexpr glm::ivec3 probe_in_brick(std::size_t p) {
    const int i = static_cast<int>(p);
    return {i % brick_size, i / brick_size % brick_size, i / (brick_size * brick_size)};
}
/// The probe in a brick's `slot`, as (i, j, k) of its grid.
[[nodiscard]] glm::ivec3 lattice_index(const Volume& volume, std::size_t slot);
/// Where the probe in `slot` was gathered.
[[nodiscard]] glm::dvec3 gather_position(const Volume& volume, std::size_t slot);
/// Its place in the lattice (or the list).
[[nodiscard]] glm::dvec3 lattice_position(const Volume& volume, std::size_t slot);

/// Finds the slot of a grid's probe: one dense table of bricks per grid, so that a look-up is two loads at most.
class SlotTable {
  public:
    static constexpr std::ptrdiff_t none = -1;

    explicit SlotTable(const Volume& volume);

    /// probe    0 <= probe < counts of the grid
    /// returns  its slot, or `none` where its brick is not stored
    [[nodiscard]] std::ptrdiff_t slot(std::size_t grid, glm::ivec3 probe) const noexcept {
        const Table& table = tables_[grid];
        const glm::ivec3 brick = probe / brick_size;
        const glm::ivec3 inside = probe - brick * brick_size;
        const std::size_t row = static_cast<std::size_t>(brick.z) * table.size.y + brick.y;
        const std::ptrdiff_t probe_of_brick =
            (inside.z * std::ptrdiff_t{brick_size} + inside.y) * brick_size + inside.x;
        const std::int32_t found = table.bricks[row * table.size.x + brick.x];
        if (found < 0) return none;
        return std::ptrdiff_t{found} * probes_per_brick + probe_of_brick;
    }

  private:
    struct Table {
        glm::ivec3 size{0};                // bricks along each axis
        std::vector<std::int32_t> bricks;  // index in Volume::bricks, or -1
    };
    std::vector<Table> tables_;
};

/// No colour anywhere: r = g = b to the bit.
[[nodiscard]] bool is_grey(std::span<const glm::vec3> values) noexcept;
/// The bands of `values` (bands^2 per slot) up to the last that is not zero everywhere; 0: all is zero.
[[nodiscard]] int used_bands(std::span<const glm::vec3> values, int bands) noexcept;

}  // namespace lightgrid
