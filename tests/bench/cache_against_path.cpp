// bench_cache_against_path SCENES DATA [NAME ...]
//
// Processor time in which light at the probes of a level comes to an error, by a surface cache and by paths, all in one
// run; SCENES is the folder of the generated levels, DATA that of real ones. Paths: their noise, from a long run. Cache:
// its share of building the cache for all probes of the level's grid, and gathers; what it is off a reference of paths
// counts as bias, which no gather removes. Of caches of several sizes the one that is there first; inf: none gets there,
// and the bias is the least of them.
//
// NAME: a generated level, behind-the-door (that part of door_ajar), breakfast-room (under an HDR sky), veach-ajar,
// modern-hall or bathroom: to 1 % relRMSE; 10-emitters or 10000-emitters, a hall under so many lamps of the same light
// in all: to 2 %. None: all.

#include "core/error.h"
#include "core/parallel.h"
#include "core/sampling.h"
#include "core/sh.h"
#include "probes/gather.h"
#include "probes/surface_cache.h"
#include "tests/bench/lit_levels.h"
#include "tests/bench/measure.h"
#include "tests/scene_builder.h"
#include "tools/program.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdio>

namespace lightgrid {
namespace {

constexpr std::uint32_t least_reference_samples = 1024;
constexpr std::uint32_t least_bias_samples = 8192;
constexpr std::uint32_t most_bias_samples = 1U << 18;
constexpr int cache_seeds = 2;

double lobe_squared(std::size_t coefficient) {
    const double lobe = cosine_lobe(static_cast<int>(std::sqrt(static_cast<double>(coefficient) + 0.5)));
    return lobe * lobe;
}

/// Variance of irradiance over all directions, summed over the points of a gather.
double noise_squared(const Gather& gather) {
    double sum = 0;
    for (std::size_t i = 0; i < gather.coefficients.size(); ++i) {
        const glm::dvec3 error = gather.coefficients[i].error;
        sum += lobe_squared(i % static_cast<std::size_t>(sh_size(gather.bands))) * glm::dot(error, error);
    }
    return sum;
}

/// Of the point, the product of x - a and y - b, over all directions; where these are independent no noise is in it.
double product(const Gather& x, const Gather& a, const Gather& y, const Gather& b, std::size_t point) {
    double sum = 0;
    for (std::size_t i = 0; i < a.sh(point).size(); ++i) {
        const glm::dvec3 first = x.sh(point)[i].mean - a.sh(point)[i].mean;
        const glm::dvec3 second = y.sh(point)[i].mean - b.sh(point)[i].mean;
        sum += lobe_squared(i) * glm::dot(first, second);
    }
    return sum;
}
double power(const Gather& a, const Gather& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.coefficients.size(); ++i) {
        sum += lobe_squared(i % static_cast<std::size_t>(sh_size(a.bands))) *
               glm::dot(a.coefficients[i].mean, b.coefficients[i].mean);
    }
    return sum;
}

/// Two independent halves of what paths say, and what they cost.
struct Reference {
    Gather a, b;
    double power = 0;
    double noise = 0;             // of their mean, relative
    double seconds_to_error = 0;  // of paths, for all points together, to the error asked for
    std::uint32_t samples = 0;
};

Reference make_reference(const PathTracer& paths, const std::vector<glm::vec3>& points, double reference_seconds,
                         double error) {
    GatherOptions options;
    options.samples = 64;
    options.seed = 1;
    const double pilot = seconds_of([&] { static_cast<void>(gather(paths, points, options)); }).processor;
    Reference reference;
    options.samples = std::max(least_reference_samples,
                               static_cast<std::uint32_t>(std::bit_floor(
                                   static_cast<std::uint64_t>(options.samples * reference_seconds / pilot))));
    reference.samples = options.samples;
    options.seed = 2;
    const double seconds = seconds_of([&] { reference.a = gather(paths, points, options); }).processor;
    options.seed = 3;
    reference.b = gather(paths, points, options);
    reference.power = power(reference.a, reference.b);
    const double noise = (noise_squared(reference.a) + noise_squared(reference.b)) / 2 / reference.power;
    reference.noise = std::sqrt(noise / 2);
    reference.seconds_to_error = seconds * noise / (error * error);
    return reference;
}

/// Time to an error by a cache of some size.
struct Attempt {
    std::uint32_t rays_per_probe = 0;
    std::uint32_t rays_per_sample = 0;
    double build = 0;  // seconds, the share of the points compared
    double gathers = 0;
    double bias = 0, bias_error = 0;  // relative squares
    CacheMade made;

    [[nodiscard]] double seconds() const { return build + gathers; }
};

/// points  that are compared, of `all` for which the cache is built
Attempt attempt(const PathTracer& paths, const std::vector<glm::vec3>& points, const std::vector<glm::vec3>& all,
                const Reference& reference, CacheOptions options, double error) {
    Attempt result;
    result.rays_per_probe = options.rays_per_probe;
    result.rays_per_sample = options.rays_per_sample;
    std::vector<double> bias(points.size());  // squares, by point
    double noise = 0;
    double seconds = 0;
    for (int seed = 0; seed < cache_seeds; ++seed) {
        options.seed = 10 + static_cast<std::uint64_t>(seed);
        std::optional<SurfaceCache> cache;
        result.build += seconds_of([&] { cache.emplace(build_surface_cache(paths, all, options)); }).processor;
        result.made = cache->made();
        GatherOptions gathering;
        gathering.seed = 20 + static_cast<std::uint64_t>(seed);
        gathering.rays.cache = &*cache;
        Gather light;
        seconds += seconds_of([&] { light = gather(paths, points, gathering); }).processor;
        const double now = noise_squared(light) / reference.power;
        noise += now;
        // So that gathers add no more noise to the measurement of bias than the reference does.
        const double wanted = gathering.samples * now / (reference.noise * reference.noise);
        gathering.samples =
            static_cast<std::uint32_t>(std::clamp(wanted, double{least_bias_samples}, double{most_bias_samples}));
        gathering.seed = 30;
        const Gather x = gather(paths, points, gathering);
        gathering.seed = 40;
        const Gather y = gather(paths, points, gathering);
        for (std::size_t i = 0; i < points.size(); ++i) {
            bias[i] += product(x, reference.a, y, reference.b, i) / (cache_seeds * reference.power);
        }
    }
    const auto n = static_cast<double>(points.size());
    for (const double b : bias) result.bias += b;
    double variance = 0;
    for (const double b : bias) variance += (b - result.bias / n) * (b - result.bias / n);
    result.bias_error = std::sqrt(variance * n / (n - 1));
    result.build *= n / static_cast<double>(all.size()) / cache_seeds;
    const double left = error * error - std::max(0.0, result.bias);
    result.gathers =
        left > 0 ? seconds / cache_seeds * noise / cache_seeds / left : std::numeric_limits<double>::infinity();
    return result;
}

double percent_of_square(double square) {
    return 100 * std::sqrt(std::max(0.0, square));
}

/// The first cache of a ladder to get there; prints a row.
void compare(const Level& level, double error) {
    const Tracer tracer(level.scene);
    const PathTracer paths(tracer, level.environment);
    CacheOptions options;
    const std::vector<glm::vec3> all = probes_of(paths, level.spacing, options);
    std::vector<glm::vec3> points;
    for (const glm::vec3& p : all) {
        if (p.x + level.scene.origin.x >= level.from_x) points.push_back(p);
    }
    points = spread_over(points, level.compared);
    const Reference reference = make_reference(paths, points, level.reference_seconds, error);
    std::optional<Attempt> best;
    for (options.rays_per_sample = 8; options.rays_per_sample <= 64; options.rays_per_sample *= 8) {
        for (options.rays_per_probe = 8; options.rays_per_probe <= 128; options.rays_per_probe *= 2) {
            const Attempt now = attempt(paths, points, all, reference, options, error);
            const bool both_miss = best && std::isinf(best->seconds()) && std::isinf(now.seconds());
            if (!best || now.seconds() < best->seconds() || (both_miss && now.bias < best->bias)) best = now;
            if (now.build > best->seconds()) break;
        }
    }
    const double each = 1e3 / static_cast<double>(points.size());
    fmt::print("| {} | {} of {} | {:.2f} | {:.2f} | {:.3f} | {:.3f} | {:.2f} ({:.2f}) | {} | {} | {:.1f} |\n",
               level.name, points.size(), all.size(), 100 * reference.noise, each * reference.seconds_to_error,
               each * best->seconds(), each * best->build, percent_of_square(best->bias),
               percent_of_square(best->bias + 2 * best->bias_error), best->rays_per_probe, best->rays_per_sample,
               reference.seconds_to_error / best->seconds());
    std::fflush(stdout);
}

void print_head() {
    fmt::print(
        "processor time of {} threads\n\n| level | probes | reference noise, % | path, ms a probe | cache, ms a probe "
        "| of that building | "
        "bias, % (at most) | cache rays a probe | a sample | path / cache "
        "|\n|---|---|---|---|---|---|---|---|---|---|\n",
        thread_count());
}

/// A hall whose ceiling holds n squares of 2 cm, all together of the same power.
Level lamps(int n) {
    Level level;
    level.name = fmt::format("{} emitters", n);
    level.spacing = 0.8;
    const int wall = add_grey(level.scene, 0.6F);
    add_box(level.scene, wall, {-8, 0, -6}, {8, 3.2F, 6}, Facing::inward);
    const int lamp = add_grey(level.scene, 0, 4e7F / static_cast<float>(n));
    for (int i = 0; i < n; ++i) {
        const glm::vec2 place =
            sobol_point(static_cast<std::uint32_t>(i), 0) * glm::vec2(15, 11) - glm::vec2(7.5F, 5.5F);
        add_quad(level.scene, lamp, {place.x, 3.1F, place.y}, {0.02F, 0, 0}, {0, 0, 0.02F});
    }
    return level;
}

/// By the name that the command line calls it.
Level level_called(const std::string& name, const std::filesystem::path& scenes, const std::filesystem::path& data) {
    const auto bitterli = [&](const char* level, const std::filesystem::path& environment = {}) {
        return load_lit_level(name, data / fmt::format("level-bitterli-{}/scene.gltf", level), environment);
    };
    if (name == "breakfast-room") return bitterli("breakfast-room", data / "env-polyhaven-1k/apartment.hdr");
    if (name == "veach-ajar" || name == "modern-hall") return bitterli(name.c_str());
    if (name == "bathroom") {
        Level level = bitterli("contemporary-bathroom");
        level.reference_seconds = 120;
        return level;
    }
    if (name != "behind-the-door") return load_lit_level(name, scenes / (name + ".glb"));
    Level level = load_lit_level(name, scenes / "door_ajar.glb");
    level.from_x = 0.1;
    level.compared = 16;
    level.reference_seconds = 240;
    return level;
}

int run(int argc, char** argv) {
    if (argc < 3) throw Error("call it with the folder of the generated levels and that of real ones");
    std::vector<std::string> names(argv + 3, argv + argc);
    if (names.empty()) {
        names = {"cornell",    "door_ajar",   "behind-the-door", "default",     "breakfast-room",
                 "veach-ajar", "modern-hall", "bathroom",        "10-emitters", "10000-emitters"};
    }
    print_head();
    for (const std::string& name : names) {
        if (name.find("-emitters") != std::string::npos) {
            compare(lamps(std::stoi(name)), 0.02);
        } else {
            compare(level_called(name, argv[1], argv[2]), 0.01);
        }
    }
    return 0;
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    return lightgrid::run_program("bench_cache_against_path", [&] { return lightgrid::run(argc, argv); });
}
