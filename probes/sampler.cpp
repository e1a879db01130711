#include "probes/sampler.h"

#include "core/error.h"
#include "core/sh.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

namespace lightgrid {
namespace {

// A point in units of a lattice: lower corner of its cell, and how far it is from there to the upper one.
struct CellPoint {
    glm::ivec3 lower{0};
    glm::dvec3 share{0};
};

// Nothing outside of the grid. What is an integer but for the rounding of positions becomes one, so that probes answer
// for themselves and the far faces belong to the grid: position and origin are each off by half a unit in the last place,
// difference and quotient again.
std::optional<CellPoint> point_in(const Grid& grid, glm::dvec3 position) noexcept {
    constexpr double unit = std::numeric_limits<double>::epsilon();
    CellPoint result;
    for (int axis = 0; axis < 3; ++axis) {
        const double spacing = grid.spacing[axis];
        const double exact = (position[axis] - grid.origin[axis]) / spacing;
        const double slack =
            unit * ((std::abs(position[axis]) + std::abs(grid.origin[axis])) / spacing + std::abs(exact));
        const double last = grid.counts[axis] - 1;
        double inside = exact > 0 ? std::min(exact, last) : 0;
        if (!(std::abs(exact - inside) <= slack)) return {};  // what is no number, too
        const double below = static_cast<int>(inside);
        const double nearest = inside - below < 0.5 ? below : below + 1;
        if (std::abs(inside - nearest) <= slack) inside = nearest;
        result.lower[axis] = static_cast<int>(inside);
        result.share[axis] = inside - result.lower[axis];
    }
    return result;
}

// The cell of a known box that a point of the box belongs to, and a point of it at which all corners carry weight.
CellPoint just_inside(const Grid& grid, const NearestKnown& nearest) noexcept {
    CellPoint result = *point_in(grid, nearest.point);
    for (int axis = 0; axis < 3; ++axis) {
        const auto probe = [&](double at) {
            return static_cast<int>(std::lround((at - grid.origin[axis]) / grid.spacing[axis]));
        };
        const int low = probe(nearest.low[axis]);
        const int high = probe(nearest.high[axis]);
        if (high == low) continue;  // a single probe along this axis
        const double place = result.lower[axis] + result.share[axis];
        result.lower[axis] = std::clamp(result.lower[axis], low, high - 1);
        result.share[axis] = std::clamp(place - result.lower[axis], border_share, 1 - border_share);
    }
    return result;
}

// bands^2 coefficients on the stack; only what is used is ever touched.
struct Scratch {
    std::array<glm::vec3, sh_size(max_sh_bands)> memory;
    // NOLINTNEXTLINE: left uninitialised on purpose
    Scratch() {}
    std::span<glm::vec3> first(std::size_t size) { return std::span(memory).first(size); }
};

}  // namespace

Sampler::Sampler(const Volume& volume)
    : volume_(volume), slots_(volume), grids_(finest_first(volume.grids)), known_(find_known_cells(volume, slots_)) {
    if (!volume.has_cells()) {
        throw Error("a probe list has no cells to interpolate in", {},
                    "Read its probes one by one, or bake a volume with a grid.");
    }
}

// No corners if one that would carry weight is not stored.
Sampler::Corners Sampler::cell_corners(std::size_t grid, glm::ivec3 lower, glm::dvec3 share) const noexcept {
    struct Corner {
        std::size_t slot;
        double weight;
        ProbeState state;
    };
    std::array<Corner, 8> stored;
    int count = 0;
    double valid_weight = 0;
    double filled_weight = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 upper(corner & 1, corner >> 1 & 1, corner >> 2);
        const double weight =
            (upper.x ? share.x : 1 - share.x) * (upper.y ? share.y : 1 - share.y) * (upper.z ? share.z : 1 - share.z);
        if (weight == 0) continue;
        const std::ptrdiff_t slot = slots_.slot(grid, lower + upper);
        if (slot == SlotTable::none) return {};
        const ProbeState state = volume_.states[slot];
        if (is_valid(state)) valid_weight += weight;
        if (state == ProbeState::filled) filled_weight += weight;
        stored[count++] = {static_cast<std::size_t>(slot), weight, state};
    }
    Corners result;
    result.known = static_cast<float>(valid_weight);
    const double sum = valid_weight > 0 ? valid_weight : filled_weight;
    for (int i = 0; i < count; ++i) {
        const bool answers = valid_weight > 0 ? is_valid(stored[i].state) : stored[i].state == ProbeState::filled;
        if (!answers) continue;
        result.slots[result.count] = stored[i].slot;
        result.weights[result.count++] = static_cast<float>(stored[i].weight / sum);
    }
    return result;
}

// Seven corners are looked at only where the nearest is not valid.
Sampler::Corners Sampler::nearest_corner(std::size_t grid, glm::ivec3 lower, glm::dvec3 share) const noexcept {
    const glm::dvec3 nearest(share.x < 0.5 ? 0 : 1, share.y < 0.5 ? 0 : 1, share.z < 0.5 ? 0 : 1);
    Corners result = cell_corners(grid, lower, nearest);
    if (result.known > 0) return result;
    result = cell_corners(grid, lower, share);
    if (result.count == 0) return result;
    const auto heaviest = std::max_element(result.weights.begin(), result.weights.begin() + result.count);
    result.slots[0] = result.slots[static_cast<std::size_t>(heaviest - result.weights.begin())];
    result.weights[0] = 1;
    result.count = 1;
    return result;
}

Sampler::Corners Sampler::answer(std::size_t grid, glm::ivec3 lower, glm::dvec3 share,
                                 Interpolation interpolation) const noexcept {
    return interpolation == Interpolation::nearest ? nearest_corner(grid, lower, share)
                                                   : cell_corners(grid, lower, share);
}

Sampler::Corners Sampler::corners_within(glm::dvec3 position, Interpolation interpolation) const noexcept {
    Corners filled;
    for (const std::size_t grid : grids_) {
        const std::optional<CellPoint> point = point_in(volume_.grids[grid], position);
        if (!point) continue;
        const Corners found = answer(grid, point->lower, point->share, interpolation);
        if (found.known > 0) return found;
        if (filled.count == 0 && found.count > 0) filled = found;
    }
    return filled;
}

Sampler::Corners Sampler::corners(glm::dvec3 position, const SampleOptions& options) const noexcept {
    Corners found = corners_within(position, options.interpolation);
    if (found.count > 0 || glm::any(glm::isnan(position))) return found;

    const std::optional<NearestKnown> nearest = nearest_known(known_, position);
    if (nearest) {
        found = corners_within(nearest->point, options.interpolation);
        if (found.count == 0) {
            const CellPoint point = just_inside(volume_.grids[nearest->grid], *nearest);
            found = answer(nearest->grid, point.lower, point.share, options.interpolation);
        }
    }
    if (options.outside == Outside::fade) {
        const double distance =
            nearest ? std::sqrt(nearest->squared_distance) : std::numeric_limits<double>::infinity();
        const double share = distance < options.fade_distance ? distance / options.fade_distance : distance > 0 ? 1 : 0;
        found.environment = static_cast<float>(found.count > 0 ? share : 1);
        found.known = static_cast<float>(share + (1 - share) * found.known);
        for (int i = 0; i < found.count; ++i) found.weights[i] *= 1 - found.environment;
    }
    return found;
}

void Sampler::interpolate(const Corners& from, const SampleOptions& options, std::span<glm::vec3> sh) const noexcept {
    std::fill(sh.begin(), sh.end(), glm::vec3(0));
    for (int c = 0; c < from.count; ++c) {
        if (options.layers.empty()) {
            // As one row of floats, which the compiler turns into vector instructions.
            const float* light = &volume_.sh(from.slots[c]).data()->x;
            float* sum = &sh.data()->x;
            const float weight = from.weights[c];
            for (std::size_t i = 0; i < 3 * sh.size(); ++i) sum[i] += weight * light[i];
            continue;
        }
        assert(options.layers.size() == volume_.layers.size());
        for (std::size_t k = 0; k < options.layers.size(); ++k) {
            const glm::vec3* light = volume_.layers[k].coefficients.data() + from.slots[c] * sh.size();
            const glm::vec3 weight = from.weights[c] * options.layers[k];
            for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += weight * light[i];
        }
    }
    if (from.environment > 0 && !options.environment.empty()) {
        assert(options.environment.size() == sh.size());
        for (std::size_t i = 0; i < sh.size(); ++i) sh[i] += from.environment * options.environment[i];
    }
}

float Sampler::sample(glm::dvec3 position, std::span<glm::vec3> sh, const SampleOptions& options) const noexcept {
    assert(sh.size() == volume_.sh_size());
    const Corners answering = corners(position, options);
    interpolate(answering, options, sh);
    return answering.known;
}

Sample Sampler::sample(glm::dvec3 position, const SampleOptions& options) const {
    Sample result{std::vector<glm::vec3>(volume_.sh_size()), 0};
    result.weight = sample(position, result.sh, options);
    return result;
}

void Sampler::sample(std::span<const glm::dvec3> positions, std::span<glm::vec3> sh, std::span<float> weights,
                     const SampleOptions& options) const noexcept {
    assert(weights.size() == positions.size() && sh.size() == positions.size() * volume_.sh_size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
        weights[i] = sample(positions[i], sh.subspan(i * volume_.sh_size(), volume_.sh_size()), options);
    }
}

glm::vec3 Sampler::irradiance(glm::dvec3 position, glm::vec3 normal, const SampleOptions& options) const noexcept {
    Scratch scratch;
    const std::span<glm::vec3> sh = scratch.first(volume_.sh_size());
    const glm::dvec3 biased = position + static_cast<double>(options.normal_bias) * glm::dvec3(normal);
    interpolate(corners(biased, options), options, sh);
    return irradiance_from_sh(sh, normal);
}

void Sampler::irradiance(std::span<const glm::dvec3> positions, std::span<const glm::vec3> normals,
                         std::span<glm::vec3> results, const SampleOptions& options) const noexcept {
    assert(positions.size() == normals.size() && positions.size() == results.size());
    for (std::size_t i = 0; i < positions.size(); ++i) results[i] = irradiance(positions[i], normals[i], options);
}

}  // namespace lightgrid
