#pragma once

#include "core/stopwatch.h"
#include "probes/error_report.h"
#include "probes/grid_choice.h"
#include "probes/kept_transport.h"
#include "probes/layers.h"
#include "probes/look_ups.h"
#include "probes/paths.h"
#include "probes/placement.h"
#include "probes/shut_out.h"
#include "probes/steering.h"
#include "probes/surface_cache.h"
#include "probes/target.h"
#include "probes/verdict.h"
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
    std::optional<int> bands;                       // none: 3, unless the target takes more
    Target target;
    std::optional<Stopwatch> clock;  // with target.seconds, and never without: runs since the program began
    Method method = Method::cache;
    std::uint64_t seed = 0;
    bool measure_error = true;      // trace held-out points and report the error, at about a quarter of the cost
    bool compare_look_ups = false;  // where the error is measured: also with fewer bands, nearest probe, half and float
    bool keep_transport = false;    // with the cache, and no time budget: see BakeResult::kept
    std::vector<LayerPlan> layers;  // with the cache, and no time budget; the paths' sources are those of their plan
    std::string environment;        // for the header: what lit the level besides its own lights
};

/// Where no target is given: gathers trace no more rays than this (10 to 35 s on two cores where it was measured). Counted in rays, not in
/// seconds, so that a bake is the same on every machine.
inline constexpr double default_ray_budget = 1e8;

/// Of a time budget: kept for what comes after the gather.
inline constexpr double finishing_share = 0.04;

struct Stage {
    std::string name;
    double seconds = 0;
    std::uint64_t rays = 0;
};

/// Probes that are gathered with as many rays each.
struct Batch {
    std::vector<std::size_t> slots;
    std::vector<glm::vec3> points;  // relative to Scene::origin
    std::uint32_t samples = 0;      // per probe
};

/// What will be baked, decided before the first gather.
struct BakePlan {
    Volume volume;                  // places and states; no light yet
    std::vector<Batch> batches;     // probes to gather: by level of refinement, coarsest first
    std::vector<glm::vec3> points;  // all of them
    std::uint32_t samples = 0;      // per probe of the first batch, in all replicates of a fixed effort
    LightEvidence light;            // what a rough look at the level's light tells of a point
    HeldOutOptions held_out;
    Method method = Method::path;      // paths where few probes make a cache not worth its while
    std::size_t first_grids = 0;       // of the volume: the others are finer ones over the same boxes
    std::optional<Steering> steering;  // where there is a target
    CacheOptions cache;
    double cache_seconds = 0;  // of the pilot's, for each ray of a probe
    std::string why_spacing;
    std::string why_samples;
    PlacementCounts placement;
    double seconds_estimate = 0;    // of gather and error measurement, from a pilot
    double reference_estimate = 0;  // of these seconds: the reference at held-out points
    double rays_per_path = 0;       // of the reference, and of gathers without a cache, from a pilot
    double bytes_estimate = 0;      // of memory while baking
    std::vector<ShutOut> shut_out;  // lights that no probe gets anything of
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
    Verdict verdict;                   // empty where nothing was measured
    ErrorPart noise;                   // over all probes: always known
    std::uint32_t replicates = 0;
    std::vector<CurvePoint> curve;  // as replicates come; one point where transport is kept or layers are solved for:
                                    // all replicates of a probe are traced at once, and lit in the end
    std::vector<LookUpCost> look_ups;  // where asked for and the error was measured
    std::vector<LeftOut> left_out;
    std::vector<Stage> stages;
    Method method = Method::path;  // paths too where no cache that was tried was good enough
    std::optional<CacheMade> cache;
    bool from_kept = false;             // by bake_from
    std::optional<KeptTransport> kept;  // where asked for, and where there was a cache; its fingerprint is the caller's
    PathCounts counts;
    std::size_t filled = 0;
};

struct Doing {
    std::string stage;
    double share = 0;                  // done, in [0, 1]
    std::uint64_t rays = 0;            // so far in this stage
    std::optional<double> error = {};  // relRMSE of what has been gathered so far: of all that is known of it
};
/// Called from any thread, one at a time. What it throws ends the work soon and comes out of plan_bake or run_bake.
using Progress = std::function<void(const Doing& doing)>;

/// Where a bake would take more than ten minutes: what takes the time and why, and how to get a first look sooner; a
/// sentence each. Empty elsewhere, and where a time was asked for.
[[nodiscard]] std::vector<std::string> why_slow(const BakePlan& plan, const Target& target);

/// As many for every probe, whatever had been decided. Whole replicates (GatherOptions).
void set_samples(BakePlan& plan, std::uint32_t samples);

[[nodiscard]] BakePlan plan_bake(const PathTracer& paths, const BakeOptions& options, const Progress& progress = {});
[[nodiscard]] BakeResult run_bake(const PathTracer& paths, const BakePlan& plan, const BakeOptions& options,
                                  const Progress& progress = {});

/// The bake of a level whose lights have changed since its transport was traced. What is not known without paths is not
/// in the result: errors but the noise.
///
/// plan  plan_of(kept)
[[nodiscard]] BakeResult bake_from(const KeptTransport& kept, const PathTracer& paths, const BakePlan& plan,
                                   const BakeOptions& options, const Progress& progress = {});

}  // namespace lightgrid
