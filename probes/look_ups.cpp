#include "probes/look_ups.h"

#include "core/sampling.h"
#include "probes/half_storage.h"

#include <algorithm>
#include <chrono>
#include <limits>

namespace lightgrid {
namespace {

constexpr std::size_t timed_look_ups = 1 << 13;
constexpr int timed_runs = 5;

struct Places {
    std::vector<glm::dvec3> positions;
    std::vector<glm::vec3> normals;
};

Places spread_over_grids(const Volume& volume, std::uint64_t seed) {
    Places places;
    RandomStream random(mix_bits(seed, 9));
    for (std::size_t i = 0; i < timed_look_ups; ++i) {
        const Grid& grid = volume.grids[i % volume.grids.size()];
        const glm::vec2 xy = random.next2();
        const glm::dvec3 u(xy, random.next());
        places.positions.push_back(grid.origin + u * glm::dvec3(grid.counts - 1) * grid.spacing);
        places.normals.push_back(sphere_direction(random.next2()));
    }
    return places;
}

double nanoseconds_each(const Volume& volume, const Places& places, const SampleOptions& options) {
    using Clock = std::chrono::steady_clock;
    const Sampler sampler(volume);
    std::vector<glm::vec3> results(places.positions.size());
    double least = std::numeric_limits<double>::infinity();
    for (int run = 0; run < timed_runs; ++run) {
        const auto start = Clock::now();
        sampler.irradiance(places.positions, places.normals, results, options);
        least = std::min(least, std::chrono::duration<double, std::nano>(Clock::now() - start).count());
    }
    return least / static_cast<double>(results.size());
}

Volume first_bands(const Volume& volume, int bands) {
    Volume result = volume;
    result.bands = bands;
    const std::size_t n = result.sh_size();
    const auto shorten = [&](std::vector<glm::vec3>& values) {
        for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
            for (std::size_t i = 0; i < n; ++i) values[slot * n + i] = values[slot * volume.sh_size() + i];
        }
        values.resize(volume.slots() * n);
    };
    shorten(result.coefficients);
    shorten(result.errors);
    return result;
}

}  // namespace

std::vector<LookUpCost> compare_look_ups(const Volume& volume, const HeldOut& reference, std::uint64_t seed) {
    const Places places = spread_over_grids(volume, seed);
    std::vector<LookUpCost> look_ups;
    for (int bands = 1; bands <= volume.bands; ++bands) {
        Volume kept = first_bands(volume, bands);
        for (const bool half : {false, true}) {
            if (half) store_as_half(kept);
            for (const Interpolation interpolation : {Interpolation::trilinear, Interpolation::nearest}) {
                const SampleOptions options{.interpolation = interpolation};
                look_ups.push_back({interpolation, bands, half, measure_total(kept, reference, options),
                                    nanoseconds_each(kept, places, options),
                                    kept.sh_size() * 3 * (half ? 2 : sizeof(float))});
            }
        }
    }
    return look_ups;
}

}  // namespace lightgrid
