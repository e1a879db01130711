// bench_primary_rays LEVEL [POINTS [RAYS]]
//
// The gather's primary loop (generate a direction, trace, project a hit on 3 bands of SH) beside rtcIntersect1 alone on
// the same rays, both on all threads: median and spread of alternating rounds, and the ratio of the medians.

#include "core/error.h"
#include "core/gltf.h"
#include "core/parallel.h"
#include "core/sampling.h"
#include "core/sh.h"
#include "core/tracer.h"
#include "tests/bench/measure.h"
#include "tests/bench/raw_scene.h"
#include "tools/program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

namespace lightgrid {
namespace {

constexpr int rounds = 9;

int run(int argc, char** argv) {
    if (argc < 2) throw Error("no LEVEL given");
    const std::size_t points = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1024;
    const std::uint32_t rays = argc > 3 ? static_cast<std::uint32_t>(std::strtoul(argv[3], nullptr, 10)) : 1024;

    const Scene scene = load_level(argv[1]);
    const Tracer tracer(scene);
    const RawScene raw(scene);
    const glm::vec3 half(0.5 * scene.bounds.size());
    std::vector<glm::vec3> origins;
    RandomStream random(1);
    for (std::size_t i = 0; i < points; ++i) {
        const glm::vec2 xy = random.next2();
        origins.push_back((glm::vec3(xy, random.next()) * 2.0F - 1.0F) * half);
    }
    const std::vector<glm::vec3> even = even_directions(rays);
    std::vector<std::vector<glm::vec3>> directions(points);
    for (std::size_t i = 0; i < points; ++i) {
        for (const glm::vec3& d : even) directions[i].push_back(random_rotation(i) * d);
    }

    std::vector<std::size_t> met_raw(points);
    std::vector<std::size_t> met(points);
    std::vector<double> raw_seconds;
    std::vector<double> our_seconds;
    std::vector<glm::dvec3> sums(points * 9);
    for (int round = 0; round <= rounds; ++round) {
        const double raw_time = seconds_of([&] {
                                    for_each_index(points, [&](std::size_t i) {
                                        met_raw[i] = 0;
                                        for (const glm::vec3& direction : directions[i])
                                            met_raw[i] += raw.hits(origins[i], direction) ? 1 : 0;
                                    });
                                }).wall;
        const double our_time =
            seconds_of([&] {
                for_each_index(points, [&](std::size_t i) {
                    met[i] = 0;
                    std::array<glm::dvec3, 9> sum{};
                    std::array<float, 9> basis{};
                    const glm::mat3 rotation = random_rotation(i);
                    for (const glm::vec3& unturned : even) {
                        const glm::vec3 direction = rotation * unturned;
                        const Hit hit = tracer.closest_hit(origins[i], direction);
                        met[i] += hit.found() ? 1 : 0;
                        sh_basis(3, direction, basis);
                        const glm::dvec3 radiance(hit.barycentric.x, hit.barycentric.y, hit.found() ? 1.0 : 0.0);
                        for (std::size_t c = 0; c < 9; ++c) sum[c] += radiance * static_cast<double>(basis[c]);
                    }
                    std::copy(sum.begin(), sum.end(), sums.begin() + static_cast<std::ptrdiff_t>(9 * i));
                });
            }).wall;
        if (round == 0) continue;  // warm-up
        raw_seconds.push_back(raw_time);
        our_seconds.push_back(our_time);
    }
    if (met != met_raw) throw Error("the two did not meet the same surfaces: no fair comparison", argv[1]);

    const double mrays = static_cast<double>(points) * rays * 1e-6;
    const Spread a = spread(raw_seconds);
    const Spread b = spread(our_seconds);
    fmt::print("{}: {} triangles, {} points x {} rays, {} threads, {} rounds\n", scene.name, tracer.triangle_count(),
               points, rays, thread_count(), rounds);
    fmt::print("rtcIntersect1 alone          {:6.2f} Mrays/s ({:.2f} to {:.2f})\n", mrays / a.median, mrays / a.most,
               mrays / a.least);
    fmt::print("generate + trace + project   {:6.2f} Mrays/s ({:.2f} to {:.2f})\n", mrays / b.median, mrays / b.most,
               mrays / b.least);
    fmt::print("ratio of medians             {:6.1f} %\n", 100 * a.median / b.median);
    return 0;
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    return lightgrid::run_program("bench_primary_rays", [&] { return lightgrid::run(argc, argv); });
}
