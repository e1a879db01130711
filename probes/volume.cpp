#include "probes/volume.h"

#include "core/error.h"
#include "core/sh.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

namespace lightgrid {
namespace {

bool is_finite(glm::dvec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

double coarseness(const Grid& grid) {
    double widest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (grid.counts[axis] > 1) widest = std::max(widest, grid.spacing[axis]);
    }
    return widest;
}

std::int64_t lattice_brick_count(const Grid& grid) {
    const glm::i64vec3 bricks(lattice_bricks(grid));
    // In floating point first: the product of three ints may not fit.
    if (static_cast<double>(bricks.x) * static_cast<double>(bricks.y) * static_cast<double>(bricks.z) > 1e18) {
        return std::numeric_limits<std::int64_t>::max();
    }
    return bricks.x * bricks.y * bricks.z;
}

bool contains(const Grid& grid, glm::ivec3 probe) {
    return glm::all(glm::greaterThanEqual(probe, glm::ivec3(0))) && glm::all(glm::lessThan(probe, grid.counts));
}

void check_bands(int bands) {
    if (bands < 1 || bands > max_sh_bands) {
        throw Error(fmt::format("{} bands, but 1 to {} are possible", bands, max_sh_bands));
    }
}

void check_grid(const Grid& grid) {
    if (glm::any(glm::lessThan(grid.counts, glm::ivec3(1)))) {
        throw Error(fmt::format("{} x {} x {} probes, but at least one is needed along each axis", grid.counts.x,
                                grid.counts.y, grid.counts.z));
    }
    if (!is_finite(grid.origin)) throw Error("the origin is not finite");
    if (!is_finite(grid.spacing) || glm::any(glm::lessThanEqual(grid.spacing, glm::dvec3(0)))) {
        throw Error(fmt::format("spacing {} x {} x {} m, but it must be positive and finite", grid.spacing.x,
                                grid.spacing.y, grid.spacing.z));
    }
    if (!is_finite(grid.position(grid.counts - 1))) throw Error("the far corner is not finite");
}

void check_grids(const std::vector<Grid>& grids) {
    std::int64_t bricks = 0;
    for (std::size_t i = 0; i < grids.size(); ++i) {
        try {
            check_grid(grids[i]);
        } catch (const Error& error) {
            throw error.inside(fmt::format("grid {}", i));
        }
        const glm::ivec3 counts = grids[i].counts;
        const std::int64_t more = lattice_brick_count(grids[i]);
        if (more > max_lattice_bricks - bricks) {
            throw Error(fmt::format("with {} x {} x {} probes, the grids span more than the {} that a volume may",
                                    counts.x, counts.y, counts.z, max_lattice_bricks * probes_per_brick),
                        fmt::format("grid {}", i), "Use a wider spacing or a smaller volume.");
        }
        bricks += more;
    }
}

void check_bricks(const Volume& volume) {
    for (std::size_t b = 0; b < volume.bricks.size(); ++b) {
        const Brick& brick = volume.bricks[b];
        const auto where = [&] { return fmt::format("brick {}", b); };
        if (brick.grid < 0 || static_cast<std::size_t>(brick.grid) >= volume.grids.size()) {
            throw Error(fmt::format("grid {}, but there are {}", brick.grid, volume.grids.size()), where());
        }
        if (brick.origin % brick_size != glm::ivec3(0) || !contains(volume.grids[brick.grid], brick.origin)) {
            throw Error(fmt::format("first probe ({}, {}, {}) is no multiple of {} inside grid {}", brick.origin.x,
                                    brick.origin.y, brick.origin.z, brick_size, brick.grid),
                        where());
        }
    }
    const SlotTable table(volume);
    for (std::size_t b = 0; b < volume.bricks.size(); ++b) {
        const Brick& brick = volume.bricks[b];
        const auto stored = static_cast<std::size_t>(table.slot(brick.grid, brick.origin)) / probes_per_brick;
        if (stored != b) throw Error(fmt::format("stored again as brick {}", stored), fmt::format("brick {}", b));
    }
}

std::string describe_slot(const Volume& volume, std::size_t slot) {
    if (slot >= volume.list_start()) return fmt::format("probe {}", slot - volume.list_start());
    const Brick& brick = volume.bricks[slot / probes_per_brick];
    const glm::ivec3 probe = brick.origin + probe_in_brick(slot % probes_per_brick);
    return fmt::format("grid {}, probe ({}, {}, {})", brick.grid, probe.x, probe.y, probe.z);
}

void check_states(const Volume& volume) {
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        const ProbeState state = volume.states[slot];
        if (state > ProbeState::missing) {
            throw Error(fmt::format("state {}, but the last one known is {}", static_cast<int>(state),
                                    static_cast<int>(ProbeState::missing)),
                        describe_slot(volume, slot));
        }
        const bool inside =
            slot >= volume.list_start() ||
            contains(volume.grids[volume.bricks[slot / probes_per_brick].grid], lattice_index(volume, slot));
        if (inside == (state == ProbeState::absent)) {
            throw Error(
                inside ? "absent, though it lies inside its grid" : "it lies outside its grid, but is not absent",
                describe_slot(volume, slot));
        }
    }
}

/// values  `per_slot` of them for each slot
void check_numbers(const Volume& volume, std::span<const glm::vec3> values, std::size_t per_slot, float least,
                   const char* what) {
    if (values.size() != volume.slots() * per_slot) {
        throw Error(fmt::format("{} values for {} probes, but {} for each were expected", values.size(), volume.slots(),
                                per_slot),
                    what);
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            const float value = values[i][c];
            if (std::isfinite(value) && value >= least) continue;
            throw Error(fmt::format("{} {}, component {}, is {}", what, i % per_slot, c, value),
                        describe_slot(volume, i / per_slot));
        }
    }
}

void check_settings(const Volume& volume) {
    for (const auto& setting : volume.settings) {
        if (setting.first.empty() || setting.first.find('=') != std::string::npos) {
            throw Error(fmt::format("the name \"{}\" is empty or has an equals sign", setting.first), "settings");
        }
    }
}

void check_layers(const Volume& volume) {
    // A layer is a part of the file; so are these.
    std::set<std::string> names{combined_layer, "combined.error", "validity", "index", "list"};
    for (const Layer& layer : volume.layers) {
        const std::string where = fmt::format("layer \"{}\"", layer.name);
        if (layer.name.empty()) throw Error("has no name", where);
        if (!names.insert(layer.name).second) throw Error("the name stands for another part as well", where);
        if (!(std::isfinite(layer.noise) && layer.noise >= 0)) {
            throw Error(fmt::format("noise {} is not finite, or negative", layer.noise), where);
        }
        check_numbers(volume, layer.coefficients, volume.sh_size(), std::numeric_limits<float>::lowest(),
                      where.c_str());
    }
}

bool same_bits(float a, float b) {
    return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

}  // namespace

std::vector<std::size_t> finest_first(std::span<const Grid> grids) {
    std::vector<std::size_t> order(grids.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return coarseness(grids[a]) < coarseness(grids[b]); });
    return order;
}

Volume make_volume(std::vector<Grid> grids, int bands, std::vector<glm::dvec3> list) {
    check_grids(grids);
    std::vector<Brick> bricks;
    for (std::size_t g = 0; g < grids.size(); ++g) {
        const glm::ivec3 counts = grids[g].counts;
        for (int z = 0; z < counts.z; z += brick_size) {
            for (int y = 0; y < counts.y; y += brick_size) {
                for (int x = 0; x < counts.x; x += brick_size) bricks.push_back({static_cast<int>(g), {x, y, z}});
            }
        }
    }
    return make_volume(std::move(grids), std::move(bricks), bands, std::move(list));
}

Volume make_volume(std::vector<Grid> grids, std::vector<Brick> bricks, int bands, std::vector<glm::dvec3> list) {
    check_bands(bands);
    check_grids(grids);
    Volume volume;
    volume.grids = std::move(grids);
    volume.bricks = std::move(bricks);
    volume.list = std::move(list);
    const std::size_t slots = volume.list_start() + volume.list.size();
    volume.states.resize(slots, ProbeState::valid);
    for (std::size_t slot = 0; slot < volume.list_start(); ++slot) {
        const Grid& grid = volume.grids[volume.bricks[slot / probes_per_brick].grid];
        if (!contains(grid, lattice_index(volume, slot))) volume.states[slot] = ProbeState::absent;
    }
    set_bands(volume, bands);
    return volume;
}

void set_bands(Volume& volume, int bands) {
    volume.bands = bands;
    volume.coefficients.assign(volume.slots() * volume.sh_size(), glm::vec3(0));
    volume.errors = volume.coefficients;
    volume.axis_errors.assign(volume.slots() * axis_normals.size(), glm::vec3(0));
    for (Layer& layer : volume.layers) layer = {layer.name, volume.coefficients, 0};
}

void append(Volume& volume, const Volume& more) {
    const auto before_list = [&](auto& values, const auto& added, std::size_t per_slot) {
        const auto rows = static_cast<std::ptrdiff_t>(volume.list.size() * per_slot);
        values.insert(values.end() - rows, added.begin(), added.end());
    };
    const std::size_t n = volume.sh_size();
    if (!volume.offsets.empty() || !more.offsets.empty()) {
        std::vector<glm::vec3> offsets = more.offsets;
        offsets.resize(more.slots());
        volume.offsets.resize(volume.slots());
        before_list(volume.offsets, offsets, 1);
    }
    before_list(volume.states, more.states, 1);
    before_list(volume.coefficients, more.coefficients, n);
    before_list(volume.errors, more.errors, n);
    before_list(volume.axis_errors, more.axis_errors, axis_normals.size());
    for (std::size_t i = 0; i < volume.layers.size(); ++i) {
        before_list(volume.layers[i].coefficients, more.layers[i].coefficients, n);
    }
    volume.grids = more.grids;
    volume.bricks.insert(volume.bricks.end(), more.bricks.begin(), more.bricks.end());
}

Volume make_probe_list(std::vector<glm::dvec3> positions, int bands) {
    return make_volume({}, bands, std::move(positions));
}

void check_volume(const Volume& volume) {
    check_bands(volume.bands);
    if (!volume.has_cells() && volume.list.empty()) throw Error("neither grids nor a probe list");
    check_grids(volume.grids);
    if (volume.has_cells() == volume.bricks.empty()) {
        throw Error(volume.has_cells() ? "no brick is stored" : "bricks without a grid");
    }
    const std::size_t slots = volume.list_start() + volume.list.size();
    if (volume.slots() != slots) throw Error(fmt::format("{} states for {} probes", volume.slots(), slots));
    check_bricks(volume);
    check_states(volume);
    for (std::size_t i = 0; i < volume.list.size(); ++i) {
        if (!is_finite(volume.list[i])) throw Error("the position is not finite", fmt::format("probe {}", i));
    }
    check_settings(volume);
    const float lowest = std::numeric_limits<float>::lowest();
    check_numbers(volume, volume.coefficients, volume.sh_size(), lowest, "coefficient");
    check_numbers(volume, volume.errors, volume.sh_size(), 0, "standard error of coefficient");
    check_numbers(volume, volume.axis_errors, axis_normals.size(), 0, "standard error of irradiance along axis");
    if (!volume.offsets.empty()) check_numbers(volume, volume.offsets, 1, lowest, "offset");
    check_layers(volume);
}

std::optional<std::size_t> find_layer(const Volume& volume, std::string_view name) noexcept {
    for (std::size_t i = 0; i < volume.layers.size(); ++i) {
        if (volume.layers[i].name == name) return i;
    }
    return {};
}

std::string sky_layer(int i) {
    return fmt::format("sky.{}", i);
}

bool has_sky_layers(const Volume& volume) noexcept {
    return find_layer(volume, "sky.0").has_value();
}

void set_sky(const Volume& volume, std::span<const glm::vec3> radiance, std::span<glm::vec3> weights) {
    for (int i = 0; i < sh_size(sky_layer_bands); ++i) {
        const std::optional<std::size_t> layer = find_layer(volume, sky_layer(i));
        if (layer) weights[*layer] = radiance[static_cast<std::size_t>(i)];
    }
}

std::size_t stored_bytes(const Volume& volume, std::span<const glm::vec3> coefficients) noexcept {
    const auto bands = static_cast<std::size_t>(std::max(1, used_bands(coefficients, volume.bands)));
    return volume.slots() * bands * bands * (is_grey(coefficients) ? 1 : 3) * (volume.half ? 2 : 4);
}

std::vector<glm::vec3> mix_layers(const Volume& volume, std::span<const glm::vec3> weights) {
    assert(weights.size() == volume.layers.size());
    std::vector<glm::vec3> sum(volume.coefficients.size(), glm::vec3(0));
    for (std::size_t k = 0; k < weights.size(); ++k) {
        const std::vector<glm::vec3>& layer = volume.layers[k].coefficients;
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weights[k] * layer[i];
    }
    return sum;
}

glm::ivec3 lattice_index(const Volume& volume, std::size_t slot) {
    return volume.bricks[slot / probes_per_brick].origin + probe_in_brick(slot % probes_per_brick);
}

glm::dvec3 lattice_position(const Volume& volume, std::size_t slot) {
    if (slot >= volume.list_start()) return volume.list[slot - volume.list_start()];
    return volume.grids[volume.bricks[slot / probes_per_brick].grid].position(lattice_index(volume, slot));
}

glm::dvec3 gather_position(const Volume& volume, std::size_t slot) {
    const glm::dvec3 place = lattice_position(volume, slot);
    return volume.offsets.empty() ? place : place + glm::dvec3(volume.offsets[slot]);
}

SlotTable::SlotTable(const Volume& volume) {
    for (const Grid& grid : volume.grids) {
        Table& table = tables_.emplace_back();
        table.size = lattice_bricks(grid);
        table.bricks.assign(static_cast<std::size_t>(lattice_brick_count(grid)), -1);
    }
    for (std::size_t b = 0; b < volume.bricks.size(); ++b) {
        Table& table = tables_[volume.bricks[b].grid];
        const glm::ivec3 at = volume.bricks[b].origin / brick_size;
        const std::size_t row = static_cast<std::size_t>(at.z) * table.size.y + at.y;
        table.bricks[row * table.size.x + at.x] = static_cast<std::int32_t>(b);
    }
}

bool is_grey(std::span<const glm::vec3> values) noexcept {
    for (const glm::vec3& v : values) {
        if (!same_bits(v.r, v.g) || !same_bits(v.g, v.b)) return false;
    }
    return true;
}

int used_bands(std::span<const glm::vec3> values, int bands) noexcept {
    const int count = sh_size(bands);
    int used = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (values[i] == glm::vec3(0)) continue;
        const int index = static_cast<int>(i % count);
        while (sh_size(used) <= index) ++used;
    }
    return used;
}

}  // namespace lightgrid
