#pragma once

#include "probes/placement.h"
#include "probes/surface_cache.h"
#include "probes/target.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

/// Before a bake with a target: rough looks, with random numbers of their own, that decide how many probes, bands and
/// rays it takes.
namespace lightgrid {

struct SteeringOptions {
    Target target;
    std::optional<int> bands;  // none: 3, or 5 where an error is asked for that fewer cannot meet
    bool may_refine = false;   // the grids may get finer
    std::int64_t max_probes = 0;
    double rays = 0;                      // that may be traced
    std::optional<double> seconds;        // instead of rays; none: the result does not depend on the clock
    const SurfaceCache* cache = nullptr;  // of the pilot; null: paths
    LightEvidence light;
    std::uint64_t seed = 0;
};

/// One look at the error of interpolation, and what was done about it.
struct Round {
    std::int64_t probes = 0;   // of the grids
    double interpolation = 0;  // relRMSE as the cells' own points have it
    std::size_t blocks = 0;    // that were divided then
};

struct Steering {
    int bands = 3;
    std::vector<double> bands_error;     // relRMSE with 1, 2, ... bands; empty: not looked at
    double interpolation = 0;            // relRMSE that is expected
    std::vector<std::uint32_t> samples;  // per probe, by level of its grid; what time allows is left to the caller
    double seconds_per_sample = 0;       // of a gather, on all threads together
    std::vector<int> levels;             // by grid: how often its spacing was halved
    std::vector<Round> rounds;
    std::size_t open_blocks = 0;   // that stay as they are: interpolation serves there, or costs less than elsewhere
    std::size_t solid_blocks = 0;  // the same: no point in them is free
    std::string why_bands, why_refined, why_samples;
    PathCounts counts;
    PlacementCounts placed;  // probes that were added
};

/// Refines `volume`, whose probes have been placed. Its light afterwards is the pilot's.
[[nodiscard]] Steering steer(const PathTracer& paths, Volume& volume, const SteeringOptions& options,
                             const std::function<void(double share)>& progress = {});

}  // namespace lightgrid
