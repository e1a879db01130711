// bench_cache_cost SCENES DATA [rate|probes|relight|furnace ...]
//
// What a surface cache costs and how its cost grows; SCENES is the folder of the generated levels, DATA that of real
// ones. Without a part named, all of them:
//
// rate     4,096 probes x 1,024 gather rays, cache included, beside rtcIntersect1 on those rays
// probes   cost of whole bakes per probe, and their memory, from 64 to 65,536 probes
// relight  whole bakes that keep their transport, and bakes in other light from it
// furnace  closed rooms of albedo a: sweeps of the solver, and error of light that must be e / (1 - a)

#include "core/error.h"
#include "core/parallel.h"
#include "core/sampling.h"
#include "probes/gather.h"
#include "probes/kept_transport.h"
#include "probes/surface_cache.h"
#include "tests/bench/lit_levels.h"
#include "tests/bench/measure.h"
#include "tests/bench/raw_scene.h"
#include "tests/scene_builder.h"
#include "tools/program.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <fstream>

namespace lightgrid {
namespace {

void rate_part(const std::filesystem::path& data) {
    constexpr std::size_t probes = 4096;
    constexpr std::uint32_t rays = 1024;
    constexpr int rounds = 5;
    fmt::print("\n{} probes x {} gather rays, of {} rounds the median, the least and the most\n\n", probes, rays,
               rounds);
    fmt::print(
        "| sky | rtcIntersect1, s | cache, s | gathers, s | cache and gathers / rtcIntersect1 |\n"
        "|---|---|---|---|---|\n");
    for (const char* sky : {"apartment", "studio", "park", "night"}) {
        const Level level = load_lit_level("breakfast-room", data / "level-bitterli-breakfast-room/scene.gltf",
                                           data / fmt::format("env-polyhaven-1k/{}.hdr", sky));
        const Tracer tracer(level.scene);
        const PathTracer paths(tracer, level.environment);
        const RawScene raw(level.scene);
        CacheOptions options;
        std::vector<glm::vec3> all = probes_of(paths, {}, options);
        for (double spacing = 0.5; all.size() < probes; spacing *= 0.9) all = probes_of(paths, spacing, options);
        const std::vector<glm::vec3> points = spread_over(all, probes);
        const std::vector<glm::vec3> even = even_directions(rays);
        std::vector<double> raws, builds, gathers, ratios;
        std::vector<std::size_t> met(points.size());
        for (int round = 0; round < rounds; ++round) {
            raws.push_back(seconds_of([&] {
                               for_each_index(points.size(), [&](std::size_t i) {
                                   const glm::mat3 rotation = random_rotation(i);
                                   for (const glm::vec3& d : even) met[i] += raw.hits(points[i], rotation * d) ? 1 : 0;
                               });
                           }).processor);
            std::optional<SurfaceCache> cache;
            builds.push_back(seconds_of([&] { cache.emplace(build_surface_cache(paths, points, options)); }).processor);
            GatherOptions gathering;
            gathering.samples = rays;
            gathering.rays.cache = &*cache;
            gathers.push_back(seconds_of([&] { static_cast<void>(gather(paths, points, gathering)); }).processor);
            ratios.push_back((builds.back() + gathers.back()) / raws.back());
        }
        const Spread ratio = spread(ratios);
        fmt::print("| {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} ({:.2f} to {:.2f}) |\n", sky, spread(raws).median,
                   spread(builds).median, spread(gathers).median, ratio.median, ratio.least, ratio.most);
        std::fflush(stdout);
    }
}

/// Most memory of the program since it was last asked, MiB (Linux).
double peak_memory() {
    std::ifstream status("/proc/self/status");
    std::string line;
    double peak = 0;
    while (std::getline(status, line)) {
        if (line.rfind("VmHWM:", 0) == 0) peak = std::stod(line.substr(6)) / 1024;
    }
    std::ofstream("/proc/self/clear_refs") << "5";
    return peak;
}

void probes_part(const std::filesystem::path& scenes) {
    fmt::print(
        "\ndefault level, 256 gather rays\n\n| probes | seconds | us a probe | MiB | bytes a probe |\n"
        "|---|---|---|---|---|\n");
    const Level level = load_lit_level("default", scenes / "default.glb");
    const Tracer tracer(level.scene);
    const PathTracer paths(tracer, level.environment);
    BakeOptions options;
    options.method = Method::cache;
    options.target.samples = 256;
    options.measure_error = false;
    CacheOptions unused;
    const std::size_t usual = probes_of(paths, 0.5, unused).size();
    peak_memory();
    const double before = peak_memory();
    for (std::size_t wanted = 64; wanted <= 65536; wanted *= 4) {
        options.placement.spacing = 0.5 * std::cbrt(static_cast<double>(usual) / static_cast<double>(wanted));
        options.placement.max_probes = 4 * wanted;
        std::size_t probes = 0;
        const Seconds spent = seconds_of([&] {
            const BakePlan plan = plan_bake(paths, options);
            probes = plan.points.size();
            static_cast<void>(run_bake(paths, plan, options));
        });
        const double memory = peak_memory() - before;
        fmt::print("| {} | {:.2f} | {:.0f} | {:.1f} | {:.0f} |\n", probes, spent.processor,
                   1e6 * spent.processor / static_cast<double>(probes), memory,
                   memory * 1024 * 1024 / static_cast<double>(probes));
        std::fflush(stdout);
    }
}

/// All of a bake but reading the level and writing the volume; then twice the light, reading what was kept included.
void relight(Level level, bool with_error) {
    BakeOptions options;
    options.keep_transport = true;
    options.measure_error = with_error;
    if (!with_error) options.target.samples = 1024;
    const std::filesystem::path file = std::filesystem::temp_directory_path() / "lightgrid-bench-relight";
    BakeResult first;
    std::size_t probes = 0;
    const Tracer tracer(level.scene);
    const double bake =
        seconds_of([&] {
            const PathTracer paths(tracer, level.environment, separate_sources(level.scene, level.environment));
            const BakePlan plan = plan_bake(paths, options);
            probes = plan.points.size();
            first = run_bake(paths, plan, options);
        }).processor;
    if (!first.kept) {
        fmt::print("| {} | {} | nothing to keep: its light was gathered by paths |\n", level.name, probes);
        return;
    }
    save_transport(*first.kept, file);
    for (Material& material : level.scene.materials) material.emission *= 2.0F;
    for (Light& light : level.scene.lights) light.intensity *= 2.0F;
    std::vector<double> again;
    for (int round = 0; round < 5; ++round) {
        again.push_back(seconds_of([&] {
                            const KeptTransport kept = *load_transport(file, first.kept->fingerprint);
                            const PathTracer paths(tracer, level.environment);
                            static_cast<void>(bake_from(kept, paths, plan_of(kept, level.scene), options));
                        }).processor);
    }
    const Spread light = spread(again);
    fmt::print("| {} | {} | {} | {:.2f} | {:.3f} ({:.3f} to {:.3f}) | {:.0f} | {:.1f} |\n", level.name, probes,
               with_error ? "2 %, measured" : "1,024 samples", bake, light.median, light.least, light.most,
               bake / light.median, static_cast<double>(std::filesystem::file_size(file)) / (1 << 20));
    std::fflush(stdout);
    std::filesystem::remove(file);
}

void relight_part(const std::filesystem::path& scenes, const std::filesystem::path& data) {
    fmt::print(
        "\n| level | probes | target | first bake, s | other light, s | ratio | MiB kept |\n"
        "|---|---|---|---|---|---|---|\n");
    for (const bool with_error : {false, true}) {
        relight(load_lit_level("cornell", scenes / "cornell.glb"), with_error);
        relight(load_lit_level("default", scenes / "default.glb"), with_error);
        relight(load_lit_level("breakfast-room", data / "level-bitterli-breakfast-room/scene.gltf",
                               data / "env-polyhaven-1k/apartment.hdr"),
                with_error);
    }
}

void furnace_part() {
    fmt::print(
        "\n| albedo | sweeps | sweeps / sqrt(1 / (1 - a)) | residual | light / (e / (1 - a)) - 1, % |\n"
        "|---|---|---|---|---|\n");
    for (const float albedo : {0.9F, 0.99F, 0.999F, 0.9999F}) {
        Level level;
        add_box(level.scene, add_grey(level.scene, albedo, 1), {-2, 0, -3}, {2, 2.5F, 3}, Facing::inward);
        const Tracer tracer(level.scene);
        const PathTracer paths(tracer, level.environment);
        CacheOptions options;
        const std::vector<glm::vec3> points = probes_of(paths, 0.5, options);
        const SurfaceCache cache = build_surface_cache(paths, points, options);
        GatherOptions gathering;
        gathering.rays.cache = &cache;
        const Gather light = gather(paths, points, gathering);
        double mean = 0;
        for (std::size_t i = 0; i < points.size(); ++i) mean += light.sh(i)[0].mean.x;
        mean /= static_cast<double>(points.size()) * 2 * std::sqrt(glm::pi<double>());
        const double bounces = 1 / (1 - static_cast<double>(albedo));
        fmt::print("| {:.4g} | {} | {:.2f} | {:.1e} | {:+.3f} |\n", albedo, cache.made().sweeps,
                   cache.made().sweeps / std::sqrt(bounces), cache.made().residual, 100 * (mean / bounces - 1));
    }
}

int run(int argc, char** argv) {
    if (argc < 3) throw Error("call it with the folder of the generated levels and that of real ones");
    const std::vector<std::string> parts(argv + 3, argv + argc);
    const auto wanted = [&](const char* part) {
        return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
    };
    fmt::print("processor time of {} threads\n", thread_count());
    if (wanted("rate")) rate_part(argv[2]);
    if (wanted("probes")) probes_part(argv[1]);
    if (wanted("relight")) relight_part(argv[1], argv[2]);
    if (wanted("furnace")) furnace_part();
    return 0;
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    return lightgrid::run_program("bench_cache_cost", [&] { return lightgrid::run(argc, argv); });
}
