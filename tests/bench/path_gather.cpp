// bench_path_gather LEVEL POINTS.csv [SAMPLES [ENVIRONMENT]]
//
// What the path gather costs at the points of a list, and what it brings: processor time and rays per gather ray,
// noise, and their product, the processor time in which a point's irradiance comes to 1 % noise. Compare products
// between versions: neither speed nor noise alone says anything.

#include "core/environment_file.h"
#include "core/error.h"
#include "core/gltf.h"
#include "core/parallel.h"
#include "probes/gather.h"
#include "tests/bench/measure.h"
#include "tools/csv.h"
#include "tools/program.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <vector>

namespace lightgrid {
namespace {

constexpr std::uint32_t replicates = 64;
constexpr double dark = 0.01;  // points with less of the median irradiance do not count by themselves

int run(int argc, char** argv) {
    if (argc < 3) throw Error("call it with LEVEL and POINTS.csv");
    const Scene scene = load_level(argv[1]);
    const Tracer tracer(scene);
    const Environment environment = argc > 4 ? load_environment(argv[4]).environment : Environment();
    const PathTracer paths(tracer, environment);
    std::vector<glm::vec3> points;
    for (const glm::dvec3& position : read_points(argv[2]).positions) points.emplace_back(position - scene.origin);

    GatherOptions options;
    options.replicates = replicates;
    options.samples = argc > 3 ? static_cast<std::uint32_t>(std::strtoul(argv[3], nullptr, 10)) : 16384;
    PathCounts counts;
    Gather light;
    const Seconds spent = seconds_of([&] { light = gather(paths, points, options, &counts); });

    // Of a gather with one ray: replicates of n rays each have 1 / n of its variance, n^-1.5 to n^-1 where the rays are
    // stratified; all figures are for replicates of this size.
    std::vector<double> noise(points.size());  // squared error and squared light, over axes and colours
    std::vector<double> power(points.size());
    double all_noise = 0;
    double all_power = 0;
    for (std::size_t i = 0; i < light.axis_irradiance.size(); ++i) {
        const Estimate& e = light.axis_irradiance[i];
        noise[i / 6] += glm::dot(e.error, e.error);
        power[i / 6] += glm::dot(e.mean, e.mean);
    }
    const double median_power = spread(power).median;
    std::vector<double> relative;
    for (std::size_t i = 0; i < points.size(); ++i) {
        all_noise += noise[i];
        all_power += power[i];
        if (power[i] > dark * dark * median_power) relative.push_back(noise[i] / power[i]);
    }
    double by_point = 0;
    for (const double r : relative) by_point += r / static_cast<double>(relative.size());
    const double pooled = all_noise / all_power;

    const double gather_rays = static_cast<double>(points.size()) * options.samples_per_replicate() * replicates;
    const auto rays = static_cast<double>(counts.rays + counts.shadow_rays);
    const double per_point = spent.processor / static_cast<double>(points.size()) * 1e4;  // (1 %)^-2
    fmt::print("{}: {} points x {} rays, {} threads\n", scene.name, points.size(), options.samples, thread_count());
    fmt::print("a gather ray       {:.3f} us, {:.2f} rays and {:.2f} shadow rays; {:.2f} Mrays/s and core\n",
               1e6 * spent.processor / gather_rays, static_cast<double>(counts.rays) / gather_rays,
               static_cast<double>(counts.shadow_rays) / gather_rays, 1e-6 * rays / spent.processor);
    fmt::print("noise              {:.3f} % of all light, {:.3f} % by point (root mean square of {} lit ones)\n",
               100 * std::sqrt(pooled), 100 * std::sqrt(by_point), relative.size());
    fmt::print("a point at 1 %     {:.3f} ms of all light, {:.3f} ms by point\n", 1e3 * per_point * pooled,
               1e3 * per_point * by_point);
    return 0;
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    return lightgrid::run_program("bench_path_gather", [&] { return lightgrid::run(argc, argv); });
}
