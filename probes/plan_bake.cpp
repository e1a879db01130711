#include "core/parallel.h"
#include "core/stopwatch.h"
#include "probes/bake.h"
#include "probes/headroom.h"
#include "probes/outer_walls.h"

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>

#include <algorithm>
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
/// Where there are so many anyway, fewer rays from each probe find the surfaces, down to the least.
constexpr double many_cache_samples = 1 << 19;
constexpr std::uint32_t least_cache_rays = 4;
/// Fewer tell nothing.
constexpr std::uint32_t least_samples = 64;
/// With fewer, intervals that resampling points gives are too narrow where a few bright ones count for much.
constexpr std::size_t least_held_out_points = 512;
constexpr std::size_t most_held_out_points = 1024;
/// Per point and half; where a time budget does not pay for so many, of the fewest points.
constexpr double least_reference_samples = 64;
/// Of the budget of rays, or of time: looking where more probes serve, the pilot's cache included.
constexpr double planning_share = 0.25;
constexpr double planning_time_share = 0.4;
/// Of the spacing: outer walls that far within the level's bounds bound the grid in their place.
constexpr double reach_of_walls = 0.5;
/// Of a time budget: placing probes, by what one brick of so many takes.
constexpr double placing_share = 0.15;
constexpr std::size_t bricks_per_timed = 8;
/// Of a time budget: the reference and the bias.
constexpr double certifying_share = 0.2;
/// Of the reference: rays to draw a point (three levels: 1,000 to 1,700, those that see whether it is open included),
/// and what a path takes with irradiance along all normals (1.2 to 1.35 times as long).
constexpr double rays_to_draw = 1500;
constexpr double slower_with_normals = 1.25;
/// That a time budget shall pay for, so that there is something to leave off.
constexpr double planned_replicates = 24;
constexpr std::uint32_t most_samples = 1U << 20;
/// Assumed before they are chosen, for the pilot's cache.
constexpr std::uint32_t pilot_cache_samples = 512;
/// In a time budget, which it would take much of, that cache has patches so many times as wide, with as many samples in
/// each.
constexpr std::uint32_t wider_pilot_patches = 2;
/// Of a time budget: the cache; where it would take more, fewer rays find the surfaces.
constexpr double cache_time_share = 0.15;
/// Of the gather rays, for the reference at held-out points.
constexpr double reference_share = 0.25;

/// Luminance of the mean radiance that arrives at a point, from a few short paths.
double rough_light(const PathTracer& paths, glm::vec3 point, std::uint64_t key, PathCounts& counts) {
    std::vector<LightSample> light;
    static const std::vector<glm::vec3> directions = even_directions(pilot_samples);
    paths.gather({point}, key, directions, light, counts, {.most_bounces = pilot_bounces});
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
    slots = spread_over<std::size_t>(slots, pilot_points);
    std::vector<double> light(slots.size());
    std::vector<PathCounts> counted(slots.size());
    for_each_index(slots.size(), [&](std::size_t i) {
        const glm::vec3 point(lattice_position(volume, slots[i]) - origin);
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

double total_rays(const PathCounts& counts) {
    return static_cast<double>(counts.rays + counts.shadow_rays);
}

double rays_per_path(const PathTracer& paths, const std::vector<glm::vec3>& points, std::uint32_t samples,
                     std::uint64_t seed, PathCounts& counts) {
    const std::size_t count = std::clamp(points.size() * samples / counted_share, std::size_t{1}, counted_paths);
    const std::vector<glm::vec3> some = spread_over<glm::vec3>(points, count);
    const auto directions = even_directions(static_cast<std::uint32_t>(count / some.size()));
    std::vector<PathCounts> counted(some.size());
    for_each_index(some.size(), [&](std::size_t i) {
        std::vector<LightSample> light;
        paths.gather({some[i]}, mix_bits(mix_bits(seed, 8), i), directions, light, counted[i]);
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
    static_cast<void>(gather(paths, spread_over<glm::vec3>(points, timed_points), options, &counted));
    const double seconds = watch.seconds();
    counts += counted;
    return seconds / total_rays(counted);
}

Cost measure_cost(const PathTracer& paths, const std::vector<glm::vec3>& points, std::uint32_t samples,
                  std::uint64_t seed, PathCounts& counts) {
    if (points.empty()) return {};
    const double rays = rays_per_path(paths, points, samples, seed, counts);
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

/// Room for objects above ground that is open to the sky, where it is left to us: metres, but no more than a share of
/// the level's width.
constexpr double headroom_share = 0.25;

void make_headroom(const Tracer& tracer, double most, Box& box, PathCounts& counts) {
    const glm::dvec3 size = tracer.scene().bounds.size();
    const double headroom = std::min(most / tracer.scene().metres_per_unit, headroom_share * std::max(size.x, size.z));
    if (!(headroom > 0)) return;
    if (const std::optional<double> top = top_of_open_ground(tracer, headroom, counts.rays))
        box.max.y = std::max(box.max.y, *top + headroom);
}

/// Grids, not behind outer walls and with headroom under the sky where it is left to us.
GridChoice grids_inside(const Tracer& tracer, const PlacementOptions& options, PathCounts& counts) {
    GridChoice choice = choose_grids(tracer.scene(), options);
    if (choice.grids.empty() || !options.boxes.empty() || !tracer.scene().volume_markers.empty()) return choice;
    const glm::dvec3 spacing = choice.grids.front().spacing;
    const double reach = reach_of_walls * std::max({spacing.x, spacing.y, spacing.z});
    Box within = within_outer_walls(tracer, reach, counts.rays);
    make_headroom(tracer, options.headroom, within, counts);
    return choose_grids(tracer.scene(), options, within);
}

std::size_t count_probes(const PlacementCounts& placed) {
    return placed.valid + placed.moved + placed.invalid;
}

/// With a time budget: coarser grids where placing their probes would take more than its share, as some bricks tell.
void fit_grids(BakePlan& plan, const PathTracer& paths, const BakeOptions& options, PathCounts& counts) {
    const Scene& scene = paths.tracer().scene();
    const std::vector<Grid>& grids = plan.volume.grids;
    const std::vector<Brick>& bricks = plan.volume.bricks;
    const Stopwatch watch;
    Volume some =
        make_volume(grids, spread_over<Brick>(bricks, (bricks.size() + bricks_per_timed - 1) / bricks_per_timed),
                    plan.volume.bands);
    const PlacementCounts placed = place_probes(some, paths.tracer(), plan.light);
    counts.rays += placed.rays;
    const double affordable = static_cast<double>(count_probes(placed)) * placing_share *
                              (*options.target.seconds - options.clock->seconds()) / watch.seconds();
    double all = 0;
    for (const Grid& grid : grids) all += double(grid.counts.x) * double(grid.counts.y) * double(grid.counts.z);
    if (affordable >= all) return;
    PlacementOptions fewer = options.placement;
    fewer.max_probes = static_cast<std::int64_t>(std::max(affordable, 8.0 * static_cast<double>(grids.size())));
    GridChoice choice = grids_inside(paths.tracer(), fewer, counts);
    plan.why_spacing = choice.why + ", as placing more would take too much of the time";
    plan.volume = make_volume(std::move(choice.grids), plan.volume.bands, scene.probe_markers);
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
    if (!use.lights) {
        left_out.push_back({"punctual lights", scene.lights.empty() ? "the level has none" : "none of them shines",
                            "a shadow ray per path vertex"});
    }
    if (!use.reflection) left_out.push_back({"reflected light", "every surface is black", "all bounces"});
    std::size_t opaque = 0;
    for (const Mesh& mesh : scene.meshes) opaque += scene.materials[mesh.material].passes_light() ? 0 : 1;
    if (opaque > 0) {
        left_out.push_back({fmt::format("alpha tests on {} of {} meshes", opaque, scene.meshes.size()),
                            "their materials let no light pass", "a look-up per ray that meets them"});
    }
    return left_out;
}

/// Groups of lights that are no layers.
void leave_out_layers(BakePlan& plan, const Scene& scene, const BakeOptions& options) {
    const auto nobody_asked = [&](const std::string& group) {
        return std::none_of(options.layers.begin(), options.layers.end(),
                            [&](const LayerPlan& layer) { return layer.name == group; });
    };
    const auto count = std::count_if(scene.groups.begin(), scene.groups.end(), nobody_asked);
    if (count == 0) return;
    const std::size_t bytes = plan.volume.coefficients.size() * sizeof(glm::vec3);
    plan.left_out.push_back({fmt::format("layers of {} groups of lights", count), "nobody asked for them (--layers)",
                             fmt::format("{:.2f} MB each at most", static_cast<double>(bytes) * 1e-6)});
}

/// Per probe, in powers of two, as the cache wants them.
std::uint32_t cache_rays(std::uint32_t samples, std::size_t probes) {
    const auto count = static_cast<double>(std::max<std::size_t>(1, probes));
    const double wanted = cache_samples_per_sample * samples / count;
    std::uint32_t rays = CacheOptions{}.rays_per_probe;
    while (rays < wanted && rays < samples) rays *= 2;
    while (rays > least_cache_rays && rays > std::max(wanted, many_cache_samples / count)) rays /= 2;
    return rays;
}

CacheOptions cache_options(const BakePlan& plan, const Scene& scene, const BakeOptions& options) {
    CacheOptions result;
    const std::uint32_t samples = plan.samples > 0 ? plan.samples : pilot_cache_samples;
    result.seed = mix_bits(options.seed, 9);
    const auto longest = [](glm::dvec3 v) { return std::max({v.x, v.y, v.z}); };
    double width = list_patch_width * longest(scene.bounds.size());
    if (!plan.volume.grids.empty()) {
        width = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < plan.first_grids; ++i) {
            width = std::min(width, patch_width * longest(plan.volume.grids[i].spacing));
        }
    }
    // Not below what float can tell apart.
    result.width = static_cast<float>(std::max({width, 0x1p-18 * longest(scene.bounds.size()), 1e-6}));
    result.rays_per_probe = cache_rays(samples, plan.points.size());
    if (options.clock && plan.cache_seconds > 0) {
        const double affordable =
            cache_time_share * *options.target.seconds / (plan.cache_seconds * static_cast<double>(plan.points.size()));
        while (result.rays_per_probe > std::max<double>(least_cache_rays, affordable)) result.rays_per_probe /= 2;
    }
    return result;
}

/// Finer grids, bands and samples, from a pilot with a cache of its own.
void steer_plan(BakePlan& plan, const PathTracer& paths, const BakeOptions& options, const Progress& progress) {
    const Stopwatch watch;
    const Scene& scene = paths.tracer().scene();
    SteeringOptions steering;
    steering.target = options.target;
    steering.bands = options.bands;
    steering.may_refine = !options.probes && !options.placement.spacing;
    steering.max_probes = options.placement.max_probes;
    steering.light = plan.light;
    steering.seed = mix_bits(options.seed, 11);
    std::optional<SurfaceCache> cache;
    PathCounts counts;
    // Where an error is asked for, probes are the limit.
    steering.rays =
        options.target.error ? std::numeric_limits<double>::infinity() : planning_share * default_ray_budget;
    if (options.clock) steering.seconds = planning_time_share * (*options.target.seconds - options.clock->seconds());
    if (plan.method == Method::cache) {
        if (progress) progress({"pilot"});
        CacheOptions rough = cache_options(plan, scene, options);
        rough.seed = mix_bits(options.seed, 12);
        if (options.clock) {
            rough.width *= wider_pilot_patches;
            rough.rays_per_probe =
                std::max(rough.rays_per_probe / (wider_pilot_patches * wider_pilot_patches), least_cache_rays);
        }
        cache = build_surface_cache(paths, plan.points, rough);
        plan.cache_seconds = watch.seconds() / (static_cast<double>(plan.points.size()) * rough.rays_per_probe);
        counts += cache->made().counts;
        steering.rays -= total_rays(counts);
        if (steering.seconds) *steering.seconds -= watch.seconds();
        steering.cache = &*cache;
    }
    plan.steering = steer(paths, plan.volume, steering, [&](double share) {
        if (progress) progress({"refine", share});
    });
    counts += plan.steering->counts;
    plan.why_samples = plan.steering->why_samples;
    const PlacementCounts& placed = plan.steering->placed;
    plan.placement.valid += placed.valid;
    plan.placement.moved += placed.moved;
    plan.placement.invalid += placed.invalid;
    plan.placement.rays += placed.rays;
    if (steering.may_refine && plan.volume.has_cells()) {
        const auto leave = [&](std::size_t blocks, const std::string& where, const std::string& evidence) {
            if (blocks == 0) return;
            plan.left_out.push_back({fmt::format("finer grids {}", where), evidence,
                                     fmt::format("about {} probes", blocks * probes_per_brick)});
        };
        leave(plan.steering->open_blocks, fmt::format("in {} blocks of up to 8 cells", plan.steering->open_blocks),
              plan.steering->why_refined);
        leave(plan.steering->solid_blocks, fmt::format("in {} blocks inside solids", plan.steering->solid_blocks),
              "no point in them is free");
    }
    set_bands(plan.volume, plan.steering->bands);
    plan.stages.push_back({"refine", watch.seconds(), placed.rays + counts.rays + counts.shadow_rays});
}

/// Which probes are gathered, and where: those of a level of grids together.
void list_probes(BakePlan& plan, const Scene& scene) {
    plan.batches.clear();
    plan.points.clear();
    for (std::size_t slot = 0; slot < plan.volume.slots(); ++slot) {
        // A list is gathered even where it is inside something: its owner asked for just these places.
        const bool listed = slot >= plan.volume.list_start();
        if (!listed && !is_valid(plan.volume.states[slot])) continue;
        const int grid = listed ? 0 : plan.volume.bricks[slot / probes_per_brick].grid;
        const auto level = static_cast<std::size_t>(plan.steering && !listed ? plan.steering->levels[grid] : 0);
        if (plan.batches.size() <= level) plan.batches.resize(level + 1);
        plan.points.emplace_back(gather_position(plan.volume, slot) - scene.origin);
        plan.batches[level].slots.push_back(slot);
        plan.batches[level].points.push_back(plan.points.back());
        if (plan.steering) plan.batches[level].samples = plan.steering->samples[level];
    }
}

void scale_samples(BakePlan& plan, double factor) {
    for (Batch& batch : plan.batches) batch.samples = whole_replicates(factor * batch.samples, most_samples);
}

double gather_rays(const BakePlan& plan) {
    double rays = 0;
    for (const Batch& batch : plan.batches) rays += static_cast<double>(batch.points.size()) * batch.samples;
    return rays;
}

void take_samples(BakePlan& plan, std::uint32_t asked) {
    const std::uint32_t replicates = GatherOptions{}.replicates;
    const std::uint32_t samples = (asked + replicates - 1) / replicates * replicates;
    set_samples(plan, samples);
    plan.why_samples = samples == asked ? "as asked" : fmt::format("{} asked, rounded up to whole replicates", asked);
}

/// Without any target: no more than the budget of rays allows.
void limit_samples(BakePlan& plan, const BakeOptions& options, const Cost& cost) {
    if (options.target.error || options.target.seconds) return;
    const double affordable = default_ray_budget / std::max(1.0, cost.rays * gather_rays(plan));
    if (affordable >= 1) return;
    scale_samples(plan, affordable);
    plan.why_samples = fmt::format("as many as {:.0f} million rays pay for; ask for less noise with --max-error",
                                   default_ray_budget * 1e-6);
}

/// With a time budget: what the time that is left pays for.
void spend_time(BakePlan& plan, const Scene& scene, const BakeOptions& options) {
    const double cache_rays_of_all =
        static_cast<double>(plan.points.size()) * cache_options(plan, scene, options).rays_per_probe;
    const double seconds = *options.target.seconds * (1 - finishing_share - certifying_share) -
                           options.clock->seconds() - plan.cache_seconds * cache_rays_of_all;
    const double planned =
        plan.steering->seconds_per_sample * gather_rays(plan) * planned_replicates / GatherOptions{}.replicates;
    scale_samples(plan, std::max(seconds, 0.0) / planned);
    plan.why_samples = "what the time pays for";
}

/// The reference at a point: drawing it, and so many paths there (in all halves).
double reference_seconds(const Cost& path, double paths) {
    if (!(path.rays > 0)) return 0;
    return rays_to_draw * path.seconds / path.rays + slower_with_normals * path.seconds * paths;
}

HeldOutOptions held_out_options(const BakePlan& plan, const BakeOptions& options, double paths_per_ray,
                                const Cost& path) {
    HeldOutOptions result;
    const double rays = reference_share * paths_per_ray * gather_rays(plan) / 2;
    // Few rays at many points: what differs from point to point is more than what the reference is unsure of.
    result.points =
        static_cast<std::size_t>(std::clamp(rays / 128, double{least_held_out_points}, double{most_held_out_points}));
    const double most = options.target.samples ? most_samples : 512;
    result.samples = static_cast<std::uint32_t>(
        std::clamp(rays / static_cast<double>(result.points), least_reference_samples, most));
    if (options.target.error || options.target.seconds) result.points = most_held_out_points;
    if (options.clock) {
        // Two halves, and two of half as many paths for the bias.
        const double seconds = certifying_share * *options.target.seconds;
        const double to_draw = reference_seconds(path, 0);
        const double to_trace = reference_seconds(path, 3) - to_draw;
        result.points =
            static_cast<std::size_t>(std::clamp(seconds / reference_seconds(path, 3 * least_reference_samples),
                                                double{least_held_out_points}, double{most_held_out_points}));
        const double samples = (seconds / static_cast<double>(result.points) - to_draw) / to_trace;
        result.samples = static_cast<std::uint32_t>(std::clamp(samples, 16.0, double{1U << 16}));
    }
    result.grids = plan.first_grids;
    result.bands = plan.volume.bands;
    result.seed = options.seed;
    return result;
}

}  // namespace

void set_samples(BakePlan& plan, std::uint32_t samples) {
    for (Batch& batch : plan.batches) batch.samples = samples;
    plan.samples = samples;
    plan.cache.rays_per_probe = cache_rays(samples, plan.points.size());
}

const char* name_of(Method method) noexcept {
    return method == Method::cache ? "cache" : "path";
}

std::vector<std::string> why_slow(const BakePlan& plan, const Target& target) {
    constexpr double long_time = 600;
    constexpr double many_rays = 40;  // a path's; in an open level a few, in a closed room of albedo 0.8 about 20
    if (target.seconds || !(plan.seconds_estimate > long_time)) return {};
    std::vector<std::string> lines;
    const double gathering = plan.seconds_estimate - plan.reference_estimate;
    if (plan.reference_estimate > gathering) {
        lines.push_back(
            fmt::format("most of it is the reference that the error is measured by: {} points, {} paths at each",
                        plan.held_out.points, 2 * plan.held_out.samples));
    } else {
        lines.push_back(
            fmt::format("most of it is gathering: {} probes, {:.0f} rays from each on average", plan.points.size(),
                        gather_rays(plan) / static_cast<double>(std::max<std::size_t>(1, plan.points.size()))));
    }
    if (plan.rays_per_path > many_rays) {
        lines.push_back(
            fmt::format("a path takes {:.0f} rays until its light has died away: lower the albedo of surfaces "
                        "that reflect nearly everything",
                        plan.rays_per_path));
    } else if (plan.reference_estimate <= gathering) {
        lines.emplace_back("a larger --spacing, a smaller --volume or a larger --max-error take less");
    }
    lines.emplace_back("for a first look in one minute: --time-budget 60s");
    return lines;
}

BakePlan plan_bake(const PathTracer& paths, const BakeOptions& options, const Progress& progress) {
    const Stopwatch watch;
    const Scene& scene = paths.tracer().scene();
    BakePlan plan;
    PathCounts pilot;
    if (options.probes) {
        plan.volume = make_probe_list(*options.probes, options.bands.value_or(3));
        plan.why_spacing = "a list: gathered exactly where it is";
    } else {
        GridChoice choice = grids_inside(paths.tracer(), options.placement, pilot);
        plan.why_spacing = choice.why;
        std::vector<glm::dvec3> list = scene.probe_markers;
        if (choice.grids.empty() && list.empty()) list.push_back(scene.origin);
        plan.volume = make_volume(std::move(choice.grids), options.bands.value_or(3), std::move(list));
    }

    plan.light = light_evidence(paths, median_light(paths, plan.volume, options.seed, pilot), options.seed);
    if (options.clock && !options.placement.spacing && !plan.volume.grids.empty())
        fit_grids(plan, paths, options, pilot);
    const auto all = static_cast<double>(plan.volume.slots());
    plan.placement = place_probes(plan.volume, paths.tracer(), plan.light, [&](std::size_t done) {
        if (progress) progress({"place", std::min(static_cast<double>(done) / all, 1.0)});
    });
    plan.first_grids = plan.volume.grids.size();
    list_probes(plan, scene);
    plan.left_out = scene.left_out;
    plan.method = options.method;
    if (options.method == Method::cache && plan.points.size() < least_cache_probes && options.layers.empty()) {
        plan.method = Method::path;
        plan.left_out.push_back({"the surface cache", fmt::format("{} probes are few", plan.points.size()),
                                 "solving for the light of all surfaces"});
    }
    plan.stages.push_back({"place", watch.seconds(), plan.placement.rays + pilot.rays + pilot.shadow_rays});
    if (!options.target.samples) {
        steer_plan(plan, paths, options, progress);
        list_probes(plan, scene);
    }
    Cost cost = measure_cost(paths, plan.points, options.target.samples.value_or(least_samples), options.seed, pilot);
    double paths_per_ray = 1;
    const Cost path = cost;
    if (plan.method == Method::cache && cost.rays > 0) {
        const double rays = 1 + (paths.estimators().emitters ? 1.0 / GatherRays{}.rays_per_emitter_sample : 0.0) +
                            (paths.estimators().environment ? 1.0 / GatherRays{}.rays_per_sky_sample : 0.0);
        paths_per_ray = std::min(1.0, rays / cost.rays);
        cost = {rays, cost.seconds * rays / cost.rays};
    }
    if (options.target.samples) {
        take_samples(plan, *options.target.samples);
    } else if (options.clock) {
        spend_time(plan, scene, options);
    } else {
        limit_samples(plan, options, cost);
    }
    plan.samples = plan.batches.empty() ? 0 : plan.batches.front().samples;
    plan.cache = cache_options(plan, scene, options);
    for (LeftOut& item : unused_estimators(paths)) plan.left_out.push_back(std::move(item));
    leave_out_layers(plan, scene, options);
    const std::size_t probes = count_probes(plan.placement);
    if (probes > plan.points.size()) {
        const std::size_t left_out = probes - plan.points.size();
        plan.left_out.push_back({fmt::format("gathers of {} probes inside solids", left_out),
                                 fmt::format("{} rays around each met back faces, and little or no light gets there",
                                             plan.placement.rays / probes),
                                 fmt::format("about {:.3g} million rays",
                                             static_cast<double>(left_out) * plan.samples * cost.rays * 1e-6)});
    }
    plan.rays_per_path = path.rays;
    plan.held_out = held_out_options(plan, options, paths_per_ray, path);
    // What the pilot's gathers took is nearer than what its paths' rays did, where a cache is read.
    const bool is_timed = plan.steering && plan.steering->seconds_per_sample > 0;
    plan.seconds_estimate = gather_rays(plan) * (is_timed ? plan.steering->seconds_per_sample : cost.seconds);
    if (options.measure_error && plan.volume.has_cells()) {
        plan.reference_estimate =
            static_cast<double>(plan.held_out.points) * reference_seconds(path, 2.0 * plan.held_out.samples);
        plan.seconds_estimate += plan.reference_estimate;
    }
    // Running sums, a replicate and the result for each point (GatherSums); two volumes, the plan's and the result's;
    // layers; and where each gather ray went, where that is kept.
    const std::size_t values = plan.volume.sh_size() + 6;
    plan.bytes_estimate =
        static_cast<double>(plan.points.size() * values * 7 * sizeof(glm::dvec3) +
                            plan.volume.slots() * (values + plan.volume.sh_size()) * 2 * sizeof(glm::vec3) +
                            options.layers.size() * plan.volume.coefficients.size() * sizeof(glm::vec3));
    const bool keeps_rays = options.keep_transport || !options.layers.empty();
    if (keeps_rays) plan.bytes_estimate += gather_rays(plan) * sizeof(std::uint32_t);
    return plan;
}

}  // namespace lightgrid
