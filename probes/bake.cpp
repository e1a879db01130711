#include "probes/bake.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/sh.h"
#include "probes/half_storage.h"

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace lightgrid {
namespace {

constexpr std::size_t pilot_points = 64;
constexpr std::uint32_t pilot_samples = 64;
constexpr std::size_t timed_points = 512;
constexpr std::uint32_t timed_samples = 16;
/// How many rays a path takes is decided by the few points whose paths hardly end: many points, a path or two at each,
/// but no more than a small share of all that will be traced.
constexpr std::size_t counted_paths = 8192;
constexpr std::size_t counted_share = 16;
/// Rough looks at a point's light need no long paths, and sealed cavities of white walls would never end them.
constexpr std::uint32_t pilot_bounces = 16;
/// With fewer probes paths should be cheaper than a cache that is as good as they are: a count of rays, not a measurement.
constexpr std::size_t least_cache_probes = 32;
/// Of a probe's spacing: wider patches blur what probes beside a wall see, narrower ones have too few samples each. A
/// quarter to the whole made no difference in a Cornell box; in a breakfast room under an HDR sky a quarter halved the
/// bias (0.3 % for 0.6 %) for nearly twice the time to build.
constexpr double patch_width = 0.5;
/// Where probes are a list: of the level's longest side.
constexpr double list_patch_width = 1.0 / 64;
/// Samples of the cache for each gather ray of one probe: all probes share them, and their noise with it.
constexpr double cache_samples_per_sample = 16;
/// Of the gather rays, for the reference at held-out points.
constexpr double reference_share = 0.25;

class Stopwatch {
  public:
    [[nodiscard]] double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Luminance of the mean radiance that arrives at a point, from a few short paths.
double rough_light(const PathTracer& paths, glm::vec3 point, std::uint64_t key, PathCounts& counts) {
    std::vector<LightSample> light;
    static const std::vector<glm::vec3> directions = even_directions(pilot_samples);
    paths.gather(point, key, directions, light, counts, {.most_bounces = pilot_bounces});
    paths.gather_punctual(point, light, counts);
    double sum = 0;
    for (const LightSample& sample : light) sum += luminance(sample.radiance);
    return sum / (4 * glm::pi<double>());
}

/// Median over lattice points of the light that gets there, among those that get any; 0 where none does.
double median_light(const PathTracer& paths, const Volume& volume, std::uint64_t seed, PathCounts& counts) {
    const glm::dvec3 origin = paths.tracer().scene().origin;
    std::vector<std::size_t> slots;
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] != ProbeState::absent) slots.push_back(slot);
    }
    const std::size_t count = std::min(pilot_points, slots.size());
    std::vector<double> light(count);
    std::vector<PathCounts> counted(count);
    for_each_index(count, [&](std::size_t i) {
        const glm::vec3 point(lattice_position(volume, slots[i * slots.size() / count]) - origin);
        light[i] = rough_light(paths, point, mix_bits(mix_bits(seed, 5), i), counted[i]);
    });
    for (const PathCounts& c : counted) counts += c;
    std::erase(light, 0.0);
    if (light.empty()) return 0;
    const auto middle = light.begin() + static_cast<std::ptrdiff_t>(light.size() / 2);
    std::nth_element(light.begin(), middle, light.end());
    return *middle;
}

/// What a gather ray costs, its whole path included.
struct Cost {
    double rays = 0;
    double seconds = 0;  // on all threads together
};

std::vector<glm::vec3> spread_over(const std::vector<glm::vec3>& points, std::size_t most) {
    const std::size_t count = std::min(most, points.size());
    std::vector<glm::vec3> some;
    for (std::size_t i = 0; i < count; ++i) some.push_back(points[i * points.size() / count]);
    return some;
}

double total_rays(const PathCounts& counts) {
    return static_cast<double>(counts.rays + counts.shadow_rays);
}

double rays_per_path(const PathTracer& paths, const std::vector<glm::vec3>& points, std::uint32_t least_samples,
                     std::uint64_t seed, PathCounts& counts) {
    const std::size_t count = std::clamp(points.size() * least_samples / counted_share, std::size_t{1}, counted_paths);
    const std::vector<glm::vec3> some = spread_over(points, count);
    const auto directions = even_directions(static_cast<std::uint32_t>(count / some.size()));
    std::vector<PathCounts> counted(some.size());
    for_each_index(some.size(), [&](std::size_t i) {
        std::vector<LightSample> light;
        paths.gather(some[i], mix_bits(mix_bits(seed, 8), i), directions, light, counted[i]);
    });
    PathCounts sum;
    for (const PathCounts& c : counted) sum += c;
    counts += sum;
    return total_rays(sum) / static_cast<double>(some.size() * directions.size());
}

double seconds_per_ray(const PathTracer& paths, const std::vector<glm::vec3>& points, std::uint64_t seed,
                       PathCounts& counts) {
    GatherOptions options;
    options.bands = 1;
    options.samples = timed_samples;
    options.replicates = 1;
    options.seed = mix_bits(seed, 7);
    PathCounts counted;
    const Stopwatch watch;
    static_cast<void>(gather(paths, spread_over(points, timed_points), options, &counted));
    const double seconds = watch.seconds();
    counts += counted;
    return seconds / total_rays(counted);
}

Cost measure_cost(const PathTracer& paths, const std::vector<glm::vec3>& points, std::uint32_t least_samples,
                  std::uint64_t seed, PathCounts& counts) {
    if (points.empty()) return {};
    const double rays = rays_per_path(paths, points, least_samples, seed, counts);
    return {rays, rays * seconds_per_ray(paths, points, seed, counts)};
}

LightEvidence light_evidence(const PathTracer& paths, double usual_light, std::uint64_t seed) {
    LightEvidence evidence;
    evidence.has_sky = paths.estimators().sky;
    if (!(usual_light > 0)) return evidence;
    evidence.share = [&paths, usual_light, seed](glm::vec3 point) {
        PathCounts counts;
        return rough_light(paths, point, mix_bits(seed, 6), counts) / usual_light;
    };
    return evidence;
}

std::string percent(double share) {
    return fmt::format("{:.2g} %", 100 * share);
}

/// What this level gives no reason to do.
std::vector<LeftOut> unused_estimators(const PathTracer& paths) {
    const Estimators& use = paths.estimators();
    const Scene& scene = paths.tracer().scene();
    std::vector<LeftOut> left_out;
    if (!use.emitters)
        left_out.push_back({"sampling of emissive surfaces", "no surface emits", "a shadow ray per path vertex"});
    if (!use.sky) {
        left_out.push_back({"environment look-ups", "the environment is black", "a look-up per ray that leaves"});
    } else if (!use.environment) {
        left_out.push_back({"importance sampling of the environment", "its radiance is the same from everywhere",
                            "a shadow ray per path vertex, and its tables"});
    }
    if (!use.lights) left_out.push_back({"punctual lights", "the level has none", "a shadow ray per path vertex"});
    if (!use.reflection) left_out.push_back({"reflected light", "every surface is black", "all bounces"});
    std::size_t opaque = 0;
    for (const Mesh& mesh : scene.meshes) opaque += scene.materials[mesh.material].passes_light() ? 0 : 1;
    if (opaque > 0) {
        left_out.push_back({fmt::format("alpha tests on {} of {} meshes", opaque, scene.meshes.size()),
                            "their materials let no light pass", "a look-up per ray that meets them"});
    }
    return left_out;
}

void choose_samples(BakePlan& plan, const BakeOptions& options, const Cost& cost) {
    const std::uint32_t replicates = GatherOptions{}.replicates;
    if (options.samples) {
        plan.samples = (*options.samples + replicates - 1) / replicates * replicates;
        plan.why_samples = plan.samples == *options.samples
                               ? "as asked"
                               : fmt::format("{} asked, rounded up to whole replicates", *options.samples);
        return;
    }
    const double affordable = default_ray_budget / std::max(1.0, cost.rays * static_cast<double>(plan.points.size()));
    plan.samples = most_default_samples;
    while (plan.samples > least_default_samples && plan.samples > affordable) plan.samples /= 2;
    plan.why_samples = plan.samples == most_default_samples
                           ? "the most by default; ask for more with --samples"
                           : fmt::format("as many as {:.0f} million rays pay for; ask for others with --samples",
                                         default_ray_budget * 1e-6);
}

CacheOptions cache_options(const BakePlan& plan, const Scene& scene, const BakeOptions& options) {
    CacheOptions result;
    result.seed = mix_bits(options.seed, 9);
    const auto longest = [](glm::dvec3 v) { return std::max({v.x, v.y, v.z}); };
    double width = list_patch_width * longest(scene.bounds.size());
    if (!plan.volume.grids.empty()) {
        width = std::numeric_limits<double>::infinity();
        for (const Grid& grid : plan.volume.grids) width = std::min(width, patch_width * longest(grid.spacing));
    }
    // Not below what float can tell apart.
    result.width = static_cast<float>(std::max({width, 0x1p-18 * longest(scene.bounds.size()), 1e-6}));
    const double wanted =
        cache_samples_per_sample * plan.samples / static_cast<double>(std::max<std::size_t>(1, plan.points.size()));
    while (result.rays_per_probe < wanted && result.rays_per_probe < plan.samples) result.rays_per_probe *= 2;
    return result;
}

HeldOutOptions held_out_options(const BakePlan& plan, const BakeOptions& options) {
    HeldOutOptions result;
    const double rays = reference_share * plan.paths_for_gathers * static_cast<double>(plan.points.size()) / 2;
    result.points = std::clamp<std::size_t>(plan.points.size() / 16, 32, 256);
    result.samples = static_cast<std::uint32_t>(
        std::max(rays / static_cast<double>(result.points), static_cast<double>(std::min(plan.samples, 256U))));
    result.bands = options.bands;
    result.seed = options.seed;
    return result;
}

/// Light of the gathered probes into the volume; the others keep what they have.
void store(const Gather& gather, const std::vector<std::size_t>& slots, Volume& volume) {
    const std::size_t n = volume.sh_size();
    for (std::size_t i = 0; i < slots.size(); ++i) {
        for (std::size_t k = 0; k < n; ++k) {
            volume.coefficients[slots[i] * n + k] = glm::vec3(gather.sh(i)[k].mean);
            volume.errors[slots[i] * n + k] = glm::vec3(gather.sh(i)[k].error);
        }
        for (std::size_t k = 0; k < 6; ++k) {
            volume.axis_errors[slots[i] * 6 + k] = glm::vec3(gather.axis_irradiance[i * 6 + k].error);
        }
    }
}

/// Root of the summed variance of irradiance over its summed square, over all directions of all gathered probes.
ErrorPart noise_at_probes(const Gather& gather) {
    double variance = 0;
    double energy = 0;
    for (std::size_t i = 0; i < gather.coefficients.size(); ++i) {
        const int k = static_cast<int>(i) % sh_size(gather.bands);
        const double lobe = cosine_lobe(static_cast<int>(std::sqrt(k + 0.5)));
        const Estimate& estimate = gather.coefficients[i];
        variance += lobe * lobe * glm::dot(estimate.error, estimate.error);
        energy += lobe * lobe * glm::dot(estimate.mean, estimate.mean);
    }
    ErrorPart noise;
    if (energy > 0) noise.relrmse = std::sqrt(variance / energy);
    noise.interval = {noise.relrmse, noise.relrmse};
    return noise;
}

}  // namespace

const char* name_of(Method method) noexcept {
    return method == Method::cache ? "cache" : "path";
}

BakePlan plan_bake(const PathTracer& paths, const BakeOptions& options, const Progress& progress) {
    const Stopwatch watch;
    const Scene& scene = paths.tracer().scene();
    BakePlan plan;
    if (options.probes) {
        plan.volume = make_probe_list(*options.probes, options.bands);
        plan.why_spacing = "a list: gathered exactly where it is";
    } else {
        GridChoice choice = choose_grids(scene, options.placement);
        plan.why_spacing = choice.why;
        std::vector<glm::dvec3> list = scene.probe_markers;
        if (choice.grids.empty() && list.empty()) list.push_back(scene.origin);
        plan.volume = make_volume(std::move(choice.grids), options.bands, std::move(list));
    }

    PathCounts pilot;
    plan.usual_light = median_light(paths, plan.volume, options.seed, pilot);
    const auto all = static_cast<double>(plan.volume.slots());
    plan.placement = place_probes(plan.volume, paths.tracer(), light_evidence(paths, plan.usual_light, options.seed),
                                  [&](std::size_t done) {
                                      if (progress)
                                          progress("place", std::min(static_cast<double>(done) / all, 1.0), 0);
                                  });
    for (std::size_t slot = 0; slot < plan.volume.slots(); ++slot) {
        // A list is gathered even where it is inside something: its owner asked for just these places.
        if (slot < plan.volume.list_start() && !is_valid(plan.volume.states[slot])) continue;
        plan.slots.push_back(slot);
        plan.points.emplace_back(gather_position(plan.volume, slot) - scene.origin);
    }
    plan.left_out = scene.left_out;
    plan.method = options.method;
    if (options.method == Method::cache && plan.points.size() < least_cache_probes) {
        plan.method = Method::path;
        plan.left_out.push_back({"the surface cache", fmt::format("{} probes are few", plan.points.size()),
                                 "solving for the light of all surfaces"});
    }
    Cost cost = measure_cost(paths, plan.points, options.samples.value_or(least_default_samples), options.seed, pilot);
    double paths_per_ray = 1;
    if (plan.method == Method::cache && cost.rays > 0) {
        const double rays = 1 + (paths.estimators().emitters ? 1.0 / GatherRays{}.rays_per_emitter_sample : 0.0) +
                            (paths.estimators().environment ? 1.0 / GatherRays{}.rays_per_sky_sample : 0.0);
        paths_per_ray = std::min(1.0, rays / cost.rays);
        cost = {rays, cost.seconds * rays / cost.rays};
    }
    choose_samples(plan, options, cost);
    plan.paths_for_gathers = paths_per_ray * plan.samples;
    plan.cache = cache_options(plan, scene, options);
    for (LeftOut& item : unused_estimators(paths)) plan.left_out.push_back(std::move(item));
    const std::size_t probes = plan.placement.valid + plan.placement.moved + plan.placement.invalid;
    if (probes > plan.points.size()) {
        const std::size_t left_out = probes - plan.points.size();
        plan.left_out.push_back({fmt::format("gathers of {} probes inside solids", left_out),
                                 fmt::format("{} rays around each met back faces, and little or no light gets there",
                                             plan.placement.rays / probes),
                                 fmt::format("about {:.3g} million rays",
                                             static_cast<double>(left_out) * plan.samples * cost.rays * 1e-6)});
    }
    const double gathers = static_cast<double>(plan.points.size()) * plan.samples;
    plan.seconds_estimate = gathers * cost.seconds * (options.measure_error ? 1 + reference_share : 1);
    // Running sums, a replicate and the result for each point (GatherSums); two volumes, the plan's and the result's.
    const std::size_t values = plan.volume.sh_size() + 6;
    plan.bytes_estimate =
        static_cast<double>(plan.points.size() * values * 7 * sizeof(glm::dvec3) +
                            plan.volume.slots() * (values + plan.volume.sh_size()) * 2 * sizeof(glm::vec3));
    plan.stages.push_back({"place", watch.seconds(), plan.placement.rays + pilot.rays + pilot.shadow_rays});
    return plan;
}

BakeResult run_bake(const PathTracer& paths, const BakePlan& plan, const BakeOptions& options,
                    const Progress& progress) {
    BakeResult result;
    result.volume = plan.volume;
    result.left_out = plan.left_out;
    result.stages = plan.stages;
    Volume& volume = result.volume;

    HeldOut held_out;
    if (!volume.has_cells()) {
        result.no_error_because = "a list has no cells to interpolate in: only the noise at the probes is known";
    } else if (!options.measure_error) {
        result.no_error_because = "not asked for: only the noise at the probes is known";
    } else {
        const Stopwatch watch;
        if (progress) progress("reference", 0, 0);
        held_out = trace_held_out(volume, paths, light_evidence(paths, plan.usual_light, options.seed),
                                  held_out_options(plan, options));
        result.counts += held_out.counts;
        result.stages.push_back({"reference", watch.seconds(), held_out.counts.rays + held_out.counts.shadow_rays});
        if (held_out.points.empty()) result.no_error_because = "no free point was found in the volume";
    }

    GatherOptions gather_options;
    gather_options.bands = options.bands;
    gather_options.samples = plan.samples;
    gather_options.seed = options.seed;
    std::optional<SurfaceCache> cache;
    if (plan.method == Method::cache) {
        const Stopwatch watch;
        if (progress) progress("cache", 0, 0);
        cache = build_surface_cache(paths, plan.points, plan.cache);
        gather_options.rays.cache = &*cache;
        result.cache = cache->made();
        result.counts += result.cache->counts;
        result.stages.push_back(
            {"cache", watch.seconds(), result.cache->counts.rays + result.cache->counts.shadow_rays});
    }
    if (cache && !held_out.points.empty()) {
        const Stopwatch watch;
        if (progress) progress("bias", 0, 0);
        BiasOptions bias_options;
        bias_options.samples = std::max(1U, held_out_options(plan, options).samples / 2);
        bias_options.seed = mix_bits(options.seed, 10);
        trace_bias(held_out, paths, *cache, bias_options);
        result.counts += held_out.bias->counts;
        result.stages.push_back(
            {"bias", watch.seconds(), held_out.bias->counts.rays + held_out.bias->counts.shadow_rays});
    }
    double seconds = 0;
    Stopwatch setup;
    GatherSums sums(paths, plan.points, gather_options);
    seconds += setup.seconds();
    const double all = static_cast<double>(plan.points.size()) * gather_options.replicates;
    for (std::uint32_t target = 1; target <= gather_options.replicates; target *= 2) {
        const Stopwatch watch;
        const double before = static_cast<double>(plan.points.size()) * sums.replicates();
        sums.add_replicates(target - sums.replicates(), [&](std::size_t done) {
            if (progress) {
                progress("gather", (before + static_cast<double>(done)) / all,
                         sums.counts().rays + sums.counts().shadow_rays);
            }
        });
        seconds += watch.seconds();
        store(sums.result(), plan.slots, volume);
        if (held_out.points.empty()) continue;
        const ErrorPart total = measure_error(volume, held_out).total;
        result.curve.push_back({seconds, target * gather_options.samples_per_replicate(),
                                sums.counts().rays + sums.counts().shadow_rays, total.relrmse, total.interval});
    }
    const Gather gathered = sums.result();
    result.counts += sums.counts();
    result.stages.push_back({"gather", seconds, sums.counts().rays + sums.counts().shadow_rays});
    result.noise = noise_at_probes(gathered);

    const Stopwatch finishing;
    result.filled = volume.has_cells() ? fill_invalid(volume, paths.tracer()) : 0;
    const StorageChoice storage = choose_storage(volume);
    std::optional<Volume> unrounded;
    if (storage.half) {
        if (!held_out.points.empty()) unrounded = volume;
        store_as_half(volume);
        result.left_out.push_back(
            {"float coefficients: half serves",
             fmt::format("rounding adds at most {} of any brick's standard error", percent(storage.worst_share)),
             "half of the bytes"});
    }
    result.stages.push_back({"finish", finishing.seconds(), 0});

    if (!held_out.points.empty()) {
        const Stopwatch watch;
        result.error = measure_error(volume, held_out, unrounded ? &*unrounded : nullptr);
        result.stages.push_back({"measure", watch.seconds(), 0});
    }
    if (!held_out.points.empty() && options.compare_look_ups) {
        const Stopwatch watch;
        result.look_ups = compare_look_ups(unrounded ? *unrounded : volume, held_out, options.seed);
        result.stages.push_back({"look-ups", watch.seconds(), 0});
    }
    volume.settings = {
        {"level", paths.tracer().scene().name},
        {"environment", options.environment.empty() ? "none" : options.environment},
        {"method", name_of(plan.method)},
        {"samples", fmt::format("{}", gather_options.samples_per_replicate() * gather_options.replicates)},
        {"replicates", fmt::format("{}", gather_options.replicates)},
        {"seed", fmt::format("{}", options.seed)},
        {"spacing", plan.why_spacing},
    };
    return result;
}

}  // namespace lightgrid
