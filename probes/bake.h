#pragma once

#include "probes/error_report.h"
#include "probes/look_ups.h"
#include "probes/paths.h"
#include "probes/placement.h"
#include "probes/surface_cache.h"
#include "probes/volume.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// The bake as a whole: plan_bake decides what will be done, run_bake does it.
namespace lightgrid {

/// How gather rays learn what surfaces reflect: each by a path of its own (unbiased), or from a surface cache that all
/// share (its noise and what it cannot resolve are the same in every replicate: bias, measured apart).
enum class Method { path, cache };
[[nodiscard]] const char* name_of(Method method) noexcept;

struct BakeOptions {
    PlacementOptions placement;
    std::optional<std::vector<glm::dvec3>> probes;  // a list to gather exactly where it is, instead of grids
    int bands = 3;
    std::optional<std::uint32_t> samples;  // gather rays per probe; none: what default_ray_budget pays for
    Method method = Method::path;
    std::uint64_t seed = 0;
    bool measure_error = true;      // trace held-out points and report the error, at about a quarter of the cost
    bool compare_look_ups = false;  // where the error is measured: also with fewer bands, nearest probe, half and float
    std::string environment;        // for the header: what lit the level besides its own lights
};

/// Where --samples is not given: the most, in powers of two, that trace no more rays than this (well under a minute on
/// two cores). Counted in rays, not in seconds, so that a bake is the same on every machine.
inline constexpr double default_ray_budget = 1e8;
inline constexpr std::uint32_t most_default_samples = 4096;
inline constexpr std::uint32_t least_default_samples = 64;

struct Stage {
    std::string name;
    double seconds = 0;
    std::uint64_t rays = 0;
};

/// What will be baked, decided before the first gather.
struct BakePlan {
    Volume volume;                   // places and states; no light yet
    std::vector<std::size_t> slots;  // probes to gather
    std::vector<glm::vec3> points;   // where, relative to Scene::origin
    std::uint32_t samples = 0;       // per probe
    double paths_for_gathers = 0;    // so many paths cost what the gather of a probe does
    Method method = Method::path;    // paths where few probes make a cache not worth its while
    CacheOptions cache;
    std::string why_spacing;
    std::string why_samples;
    PlacementCounts placement;
    double usual_light = 0;       // luminance of the mean radiance that probes get, their median; from a pilot
    double seconds_estimate = 0;  // of gather and error measurement, from a pilot
    double bytes_estimate = 0;    // of memory while baking
    std::vector<LeftOut> left_out;
    std::vector<Stage> stages;
};

struct CurvePoint {
    double seconds = 0;  // of gathering, so far
    std::uint32_t samples = 0;
    std::uint64_t rays = 0;
    double relrmse = 0;
    Interval interval;
};

struct BakeResult {
    Volume volume;
    std::optional<ErrorReport> error;  // grids only, where asked for and where any free point was found
    std::string no_error_because;      // why not
    ErrorPart noise;                   // over all probes: always known
    std::vector<CurvePoint> curve;
    std::vector<LookUpCost> look_ups;  // where asked for and the error was measured
    std::vector<LeftOut> left_out;
    std::vector<Stage> stages;
    std::optional<CacheMade> cache;
    PathCounts counts;
    std::size_t filled = 0;
};

/// stage, share done in [0, 1], rays so far in this stage. Called from any thread, one at a time. What it throws ends the
/// work soon and comes out of plan_bake or run_bake.
using Progress = std::function<void(const std::string& stage, double share, std::uint64_t rays)>;

[[nodiscard]] BakePlan plan_bake(const PathTracer& paths, const BakeOptions& options, const Progress& progress = {});
[[nodiscard]] BakeResult run_bake(const PathTracer& paths, const BakePlan& plan, const BakeOptions& options,
                                  const Progress& progress = {});

}  // namespace lightgrid
