// What layers cost a look-up: irradiance of the same places from the combined light, from weighted layers, and from light
// that was mixed of them once. One thread, processor time, in turns.
//
//     bench_layers VOLUME [ROUNDS]

#include "core/error.h"
#include "core/sampling.h"
#include "probes/sampler.h"
#include "probes/volume_file.h"
#include "tests/bench/measure.h"
#include "tools/program.h"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <string>
#include <vector>

namespace lightgrid {
namespace {

constexpr std::array<std::size_t, 5> counts{1, 2, 4, 8, 12};  // of layers; 12: two groups, the rest, and any sky
constexpr std::size_t look_ups = 200'000;

/// Evenly spread over the first grid.
struct Places {
    std::vector<glm::dvec3> positions;
    std::vector<glm::vec3> normals;

    explicit Places(const Grid& grid) {
        const glm::dvec3 size = grid.spacing * glm::dvec3(grid.counts - 1);
        for (std::uint32_t i = 0; i < look_ups; ++i) {
            const glm::vec2 xy = sobol_point(i, 1);
            positions.push_back(grid.origin + size * glm::dvec3(xy.x, xy.y, sobol_point(i, 2).x));
            normals.push_back(sphere_direction(sobol_point(i, 3)));
        }
    }
};

/// The same light in so many equal parts: what a look-up costs does not depend on how it is divided.
Volume divided(Volume volume, std::size_t layers) {
    volume.layers.assign(layers, {"part", volume.coefficients});
    return volume;
}

void run(const std::string& file, int rounds) {
    const Volume combined = load_volume(file);
    const Sampler sampler(combined);
    const Places places(combined.grids.front());
    std::vector<glm::vec3> lux(look_ups);
    const auto look_up = [&](const Sampler& from, std::span<const glm::vec3> weights) {
        return seconds_of([&] { from.irradiance(places.positions, places.normals, lux, {.layers = weights}); })
            .processor;
    };
    look_up(sampler, {});  // once for nothing: pages and caches

    std::vector<double> again;
    std::vector<double> plain_ns;
    fmt::print("{}: {} probes, {} bands, {} look-ups in {} rounds\n", file, combined.slots(), combined.bands, look_ups,
               rounds);
    for (const std::size_t count : counts) {
        const Volume volume = divided(combined, count);
        const Sampler layered(volume);
        const std::vector<glm::vec3> weights(count, glm::vec3(1.0F / static_cast<float>(count)));
        look_up(layered, weights);
        std::vector<double> ratios;
        std::vector<double> mixing_ms;
        std::vector<double> worth;
        for (int round = 0; round < rounds; ++round) {
            const double plain = look_up(sampler, {});
            const double mixed = look_up(layered, weights);
            const double mixing = seconds_of([&] { static_cast<void>(mix_layers(volume, weights)); }).processor;
            again.push_back(look_up(sampler, {}) / plain);
            plain_ns.push_back(1e9 * plain / look_ups);
            ratios.push_back(mixed / plain);
            mixing_ms.push_back(1000 * mixing);
            worth.push_back(mixing * look_ups / (mixed - plain));
        }
        const Spread ratio = spread(ratios);
        fmt::print(
            "{:2} layers: {:.2f} ({:.2f} to {:.2f}) of a combined look-up; mixed once in {:.2f} ms, which is "
            "worth it from {:.0f} look-ups\n",
            count, ratio.median, ratio.least, ratio.most, spread(mixing_ms).median, spread(worth).median);
    }
    const Spread ratio = spread(again);
    fmt::print("combined again: {:.2f} ({:.2f} to {:.2f}); {:.0f} ns a look-up\n", ratio.median, ratio.least,
               ratio.most, spread(plain_ns).median);
}

}  // namespace
}  // namespace lightgrid

int main(int argc, char** argv) {
    using namespace lightgrid;
    return run_program("bench_layers", [&] {
        if (argc < 2) throw Error("no VOLUME", {}, "bench_layers VOLUME [ROUNDS]");
        run(argv[1], argc > 2 ? std::atoi(argv[2]) : 15);
        return 0;
    });
}
