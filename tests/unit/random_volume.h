#pragma once

#include "probes/volume.h"

#include <glm/glm.hpp>

#include <array>
#include <cmath>
#include <random>
#include <vector>

/// Volumes that leave no case out, and points to ask them at.
namespace lightgrid {

inline const Grid fine_grid{{-3.3, 7.1, 100.7}, {0.31, 0.4, 0.29}, {10, 6, 14}};
inline const Grid coarse_grid{{-5.1, 6.2, 99}, {1.3, 1.1, 1.7}, {8, 7, 5}};

/// Light that is different at every probe and bright enough in band 0 for irradiance to be positive; states by `state`.
template <typename State>
[[nodiscard]] Volume random_volume(std::vector<Grid> grids, int bands, State state) {
    Volume volume = make_volume(std::move(grids), bands);
    std::mt19937 random(11);
    std::uniform_real_distribution<float> uniform(-1, 1);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        volume.states[slot] = state(random);
        const float brightness = std::exp2(4 * uniform(random));
        for (std::size_t i = 0; i < volume.sh_size(); ++i) {
            const glm::vec3 noise(uniform(random), uniform(random), uniform(random));
            volume.coefficients[slot * volume.sh_size() + i] = brightness * (i == 0 ? 3.0F + noise : 0.5F * noise);
        }
    }
    check_volume(volume);
    return volume;
}

inline ProbeState all_valid(std::mt19937&) {
    return ProbeState::valid;
}

/// Half of the probes are invalid, so that cells of all kinds occur.
inline ProbeState any_state(std::mt19937& random) {
    constexpr std::array<ProbeState, 6> states{ProbeState::valid,  ProbeState::valid,  ProbeState::moved,
                                               ProbeState::filled, ProbeState::filled, ProbeState::missing};
    return states[random() % states.size()];
}

/// As in a level of thick walls: one probe in eight is invalid.
inline ProbeState mostly_valid(std::mt19937& random) {
    return random() % 8 == 0 ? ProbeState::filled : ProbeState::valid;
}

/// Takes every third brick away.
inline void thin_out(Volume& volume) {
    Volume thinned = volume;
    thinned.bricks.clear();
    thinned.states.clear();
    thinned.coefficients.clear();
    for (std::size_t b = 0; b < volume.bricks.size(); ++b) {
        if (b % 3 == 1) continue;
        thinned.bricks.push_back(volume.bricks[b]);
        for (std::size_t p = 0; p < probes_per_brick; ++p) {
            const std::size_t slot = b * probes_per_brick + p;
            thinned.states.push_back(volume.states[slot]);
            const auto sh = volume.sh(slot);
            thinned.coefficients.insert(thinned.coefficients.end(), sh.begin(), sh.end());
        }
    }
    thinned.errors.assign(thinned.coefficients.size(), glm::vec3(0));
    thinned.axis_errors.assign(6 * thinned.states.size(), glm::vec3(0));
    check_volume(thinned);
    volume = std::move(thinned);
}

/// A volume of nested, overlapping and separate grids of all sizes, a single probe along some axes, of which bricks are
/// missing, and in others all light.
[[nodiscard]] inline Volume random_sparse_volume(unsigned seed, int bands) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    const auto random_vector = [&] { return glm::dvec3(uniform(random), uniform(random), uniform(random)); };
    std::vector<Grid> grids;
    std::vector<Brick> bricks;
    for (int grid = 0; grid < 1 + static_cast<int>(seed % 4); ++grid) {
        const double spacing = std::exp2(-uniform(random) * grid);
        glm::ivec3 counts(1 + static_cast<int>(13 * uniform(random)), 2 + static_cast<int>(9 * uniform(random)),
                          2 + static_cast<int>(17 * uniform(random)));
        if (grid == 0) counts = glm::max(counts, 5);  // room for a brick of whole cells
        grids.push_back(
            {glm::dvec3(12.3, -7, 101) + 6.0 * random_vector(), spacing * (0.7 + 0.6 * random_vector()), counts});
        const double share_stored = 0.3 + 0.7 * uniform(random);
        const glm::ivec3 spanned = lattice_bricks(grids.back());
        for (int i = 0; i < spanned.x * spanned.y * spanned.z; ++i) {
            if (i > 0 && uniform(random) > share_stored) continue;
            const glm::ivec3 at(i % spanned.x, i / spanned.x % spanned.y, i / (spanned.x * spanned.y));
            bricks.push_back({grid, brick_size * at});
        }
    }
    Volume volume = make_volume(std::move(grids), std::move(bricks), bands);
    for (std::size_t b = 0; b < volume.bricks.size(); ++b) {
        const bool dark = b > 0 && uniform(random) < 0.1;
        const bool full = uniform(random) < 0.5;
        for (std::size_t slot = b * probes_per_brick; slot < (b + 1) * probes_per_brick; ++slot) {
            if (volume.states[slot] == ProbeState::absent) continue;
            volume.states[slot] = dark ? ProbeState::missing : full ? ProbeState::valid : any_state(random);
            for (std::size_t i = 0; i < volume.sh_size(); ++i) {
                const glm::vec3 noise(random_vector() - 0.5);
                volume.coefficients[slot * volume.sh_size() + i] = i == 0 ? 2.0F + noise : 0.5F * noise;
            }
        }
    }
    check_volume(volume);
    return volume;
}

struct Query {
    glm::vec3 position;  // relative to the textures' origin
    glm::vec3 normal;
};

/// Points in and around the grids' box.
[[nodiscard]] inline std::vector<Query> random_queries(const Volume& volume, glm::dvec3 origin, int count) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-0.1, 1.1);
    std::normal_distribution<float> normal;
    std::vector<Query> queries;
    for (int i = 0; i < count; ++i) {
        const Grid& grid = volume.grids[static_cast<std::size_t>(i) % volume.grids.size()];
        const glm::dvec3 share(uniform(random), uniform(random), uniform(random));
        const glm::dvec3 position = grid.origin + share * (grid.spacing * glm::dvec3(grid.counts - 1));
        queries.push_back(
            {glm::vec3(position - origin), glm::normalize(glm::vec3(normal(random), normal(random), normal(random)))});
    }
    return queries;
}

/// Points in the box round all grids and up to two of the widest spacings outside of it.
[[nodiscard]] inline std::vector<Query> queries_around(const Volume& volume, glm::dvec3 origin, int count) {
    glm::dvec3 low = volume.grids.front().origin;
    glm::dvec3 high = low;
    glm::dvec3 spacing(0);
    for (const Grid& grid : volume.grids) {
        low = glm::min(low, grid.origin);
        high = glm::max(high, grid.position(grid.counts - 1));
        spacing = glm::max(spacing, grid.spacing);
    }
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::normal_distribution<float> normal;
    std::vector<Query> queries;
    for (int i = 0; i < count; ++i) {
        const glm::dvec3 share(uniform(random), uniform(random), uniform(random));
        const glm::dvec3 position = glm::mix(low - 2.0 * spacing, high + 2.0 * spacing, share);
        queries.push_back(
            {glm::vec3(position - origin), glm::normalize(glm::vec3(normal(random), normal(random), normal(random)))});
    }
    return queries;
}

}  // namespace lightgrid
