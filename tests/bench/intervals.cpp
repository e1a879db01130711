// bench_intervals SCENES DATA SEEDS [NAME ...]
//
// How often the 95 % intervals of the reported error hold the true one. Each level is baked with SEEDS seeds, each with
// probe samples and held-out points of its own, 256 gather rays a probe. The truth is that run's own: what its volume
// is off 16,384 points in all open space, which are traced once for the level and which no bake knows of. It has an
// error too: printed beside it, as a share of the intervals' mean width, is half the width of an interval of its own.
//
// SCENES is the folder of the generated levels, DATA that of real ones. NAME: a generated level, NAME-sun (under a sun
// and sky), breakfast-room (under an HDR sky), veach-ajar, modern-hall or bathroom. None: the four of the README.

#include "core/error.h"
#include "core/parallel.h"
#include "core/sh.h"
#include "core/sun_sky.h"
#include "probes/bake.h"
#include "probes/sampler.h"
#include "tests/bench/lit_levels.h"
#include "tests/bench/measure.h"
#include "tools/program.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace lightgrid {
namespace {

constexpr std::size_t true_points = 16384;
constexpr std::uint32_t true_samples = 64;  // per point and half
constexpr std::uint32_t samples = 256;      // of a bake
constexpr double coarser = 1.5;             // than the spacing chosen by default, so that a bake takes a second or two

/// Of a point, over normals and colours: E that the path tracer says, in two halves, and of its first bands.
struct Truth {
    HeldOut held_out;
    std::vector<glm::dvec3> a, b, bands_a, bands_b;
    double reference = 0;  // sum A B
    double bands = 0;      // relRMSE
    double spread = 0;     // half the width of the interval of a total
};

/// Shares of squares, of a volume: total, and all but bands.
struct Errors {
    double total = 0, rest = 0;
};

Truth trace_truth(const PathTracer& paths, const BakePlan& plan) {
    Truth truth;
    HeldOutOptions options = plan.held_out;
    options.points = true_points;
    options.samples = true_samples;
    options.seed = ~std::uint64_t{0};
    truth.held_out = trace_held_out(plan.volume, paths, plan.light, options);
    const std::vector<glm::vec3>& normals = held_out_normals();
    double bands = 0;
    for (std::size_t i = 0; i < truth.held_out.points.size(); ++i) {
        std::vector<glm::vec3> sh_a;
        std::vector<glm::vec3> sh_b;
        for (const Estimate& estimate : truth.held_out.a.sh(i)) sh_a.emplace_back(estimate.mean);
        for (const Estimate& estimate : truth.held_out.b.sh(i)) sh_b.emplace_back(estimate.mean);
        for (std::size_t k = 0; k < normals.size(); ++k) {
            truth.a.push_back(truth.held_out.a.irradiance[i * normals.size() + k].mean);
            truth.b.push_back(truth.held_out.b.irradiance[i * normals.size() + k].mean);
            truth.bands_a.emplace_back(irradiance_from_sh(sh_a, normals[k]));
            truth.bands_b.emplace_back(irradiance_from_sh(sh_b, normals[k]));
            const double weight = truth.held_out.weights[i];
            truth.reference += weight * glm::dot(truth.a.back(), truth.b.back());
            bands += weight * glm::dot(truth.a.back() - truth.bands_a.back(), truth.b.back() - truth.bands_b.back());
        }
    }
    truth.bands = std::sqrt(std::max(bands / truth.reference, 0.0));
    return truth;
}

Errors errors_of(const Volume& volume, const Truth& truth) {
    const Sampler sampler(volume);
    const std::vector<glm::vec3>& normals = held_out_normals();
    std::vector<Errors> points(truth.held_out.points.size());
    for_each_index(points.size(), [&](std::size_t i) {
        const Sample sample = sampler.sample(truth.held_out.points[i]);
        for (std::size_t k = 0; k < normals.size(); ++k) {
            const std::size_t index = i * normals.size() + k;
            const glm::dvec3 ours(irradiance_from_sh(sample.sh, normals[k]));
            points[i].total += glm::dot(ours - truth.a[index], ours - truth.b[index]);
            points[i].rest += glm::dot(ours - truth.bands_a[index], ours - truth.bands_b[index]);
        }
    });
    Errors errors;
    for (std::size_t i = 0; i < points.size(); ++i) {
        errors.total += truth.held_out.weights[i] * points[i].total / truth.reference;
        errors.rest += truth.held_out.weights[i] * points[i].rest / truth.reference;
    }
    return {std::sqrt(std::max(errors.total, 0.0)), std::sqrt(std::max(errors.rest, 0.0))};
}

/// What became of the intervals of a part of the error.
struct Coverage {
    int below = 0, above = 0, runs = 0;  // where the truth was
    double truth = 0, width = 0;         // sums

    void count(double is, const ErrorPart& said) {
        below += is < said.interval.low ? 1 : 0;
        above += is > said.interval.high ? 1 : 0;
        ++runs;
        truth += is;
        width += said.interval.high - said.interval.low;
    }
    Coverage& operator+=(const Coverage& other) {
        below += other.below;
        above += other.above;
        runs += other.runs;
        truth += other.truth;
        width += other.width;
        return *this;
    }
    [[nodiscard]] std::string row() const {
        return fmt::format("{:.1f} | {} | {} | {:.2f} | {:.2f}", 100.0 * (runs - below - above) / runs, below, above,
                           100 * truth / runs, width / truth);
    }
};

constexpr std::array<const char*, 3> part_names{"total", "all but bands", "bands"};
using Parts = std::array<Coverage, part_names.size()>;

Parts bake_many(const Level& level, int seeds) {
    const Tracer tracer(level.scene);
    const PathTracer paths(tracer, level.environment);
    BakeOptions options;
    options.placement.spacing = coarser * choose_grids(level.scene, {}).grids.front().spacing.x;
    options.target.samples = samples;
    options.seed = static_cast<std::uint64_t>(seeds);
    BakePlan plan = plan_bake(paths, options);
    Truth truth = trace_truth(paths, plan);
    Parts parts;
    double seconds = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        options.seed = static_cast<std::uint64_t>(seed);
        BakeResult result;
        seconds += seconds_of([&] {
                       plan = plan_bake(paths, options);
                       result = run_bake(paths, plan, options);
                   }).processor;
        if (seed == 0) {
            const Interval interval = measure_error(result.volume, truth.held_out).total.interval;
            truth.spread = 0.5 * (interval.high - interval.low);
        }
        const Errors is = errors_of(result.volume, truth);
        parts[0].count(is.total, result.error->total);
        parts[1].count(is.rest, result.error->without_bands);
        parts[2].count(truth.bands, result.error->bands);
    }
    fmt::print(
        "\n{}: {} probes, {} held-out points, {:.2f} s of the processor a bake; truth known to {:.2f} of a "
        "width\n",
        level.name, plan.points.size(), plan.held_out.points, seconds / seeds, truth.spread / (parts[0].width / seeds));
    return parts;
}

void print_rows(const std::string& level, const Parts& parts) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
        fmt::print("| {} | {} | {} | {} |\n", level, part_names[i], parts[i].runs, parts[i].row());
    }
    std::fflush(stdout);
}

Level level_called(const std::string& name, const std::filesystem::path& scenes, const std::filesystem::path& data) {
    const auto bitterli = [&](const std::string& level, const std::filesystem::path& environment = {}) {
        return load_lit_level(name, data / fmt::format("level-bitterli-{}/scene.gltf", level), environment);
    };
    if (name == "breakfast-room") return bitterli(name, data / "env-polyhaven-1k/apartment.hdr");
    if (name == "veach-ajar" || name == "modern-hall") return bitterli(name);
    if (name == "bathroom") return bitterli("contemporary-bathroom");
    const std::size_t sun = name.find("-sun");
    Level level = load_lit_level(name, scenes / (name.substr(0, sun) + ".glb"));
    if (sun != std::string::npos) level.environment = make_sun_sky({});
    return level;
}

int run(int argc, char** argv) {
    if (argc < 4) throw Error("call it with the folder of the generated levels, that of real ones, and how many seeds");
    const int seeds = std::max(1, std::atoi(argv[3]));
    std::vector<std::string> names(argv + 4, argv + argc);
    if (names.empty()) names = {"cornell", "default", "breakfast-room", "veach-ajar"};
    Parts pooled;
    fmt::print("| level | part | runs | held, % | truth below | truth above | truth, % | mean width / truth |\n");
    fmt::print("|---|---|---|---|---|---|---|---|\n");
    for (const std::string& name : names) {
        const Parts parts = bake_many(level_called(name, argv[1], argv[2]), seeds);
        print_rows(name, parts);
        for (std::size_t i = 0; i < parts.size(); ++i) pooled[i] += parts[i];
    }
    print_rows("all", pooled);
    return 0;
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    return lightgrid::run_program("bench_intervals", [&] { return lightgrid::run(argc, argv); });
}
