#include "probes/transport.h"

#include "core/parallel.h"
#include "probes/linear_solver.h"

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

constexpr std::size_t patches_per_task = 256;
constexpr int most_sweeps = 2000;

double largest(glm::dvec3 v) {
    return std::max({v.x, v.y, v.z});
}

}  // namespace

void add_transported(const Transport& transport, std::span<const glm::dvec3> light, std::span<glm::dvec3> sum) {
    const std::size_t tasks = (transport.patches() + patches_per_task - 1) / patches_per_task;
    for_each_index(tasks, [&](std::size_t task) {
        const std::size_t end = std::min(transport.patches(), (task + 1) * patches_per_task);
        const auto before = [](const Transport::PassedRay& ray, std::uint32_t sample) { return ray.from < sample; };
        auto ray = std::lower_bound(transport.passed.begin(), transport.passed.end(),
                                    transport.first_sample[task * patches_per_task], before);
        for (std::size_t patch = task * patches_per_task; patch < end; ++patch) {
            glm::dvec3 arrived(0);
            for (std::uint32_t s = transport.first_sample[patch]; s < transport.first_sample[patch + 1]; ++s) {
                glm::dvec3 from_rays(0);
                const std::uint32_t* landed = transport.landed.data() + std::size_t{s} * transport.rays;
                for (std::uint32_t r = 0; r < transport.rays; ++r) {
                    if (landed[r] < Transport::sky) from_rays += light[landed[r]];
                }
                for (; ray != transport.passed.end() && ray->from == s; ++ray) {
                    if (ray->patch < Transport::sky) from_rays += glm::dvec3(ray->share) * light[ray->patch];
                }
                arrived += glm::dvec3(transport.weights[s]) * from_rays;
            }
            sum[patch] += arrived;
        }
    });
}

TransportSolution solve(const Transport& transport, std::span<const glm::dvec3> direct, double accuracy) {
    // Row sums of T are at most the albedo.
    double largest_albedo = 0;
    for (std::size_t patch = 0; patch < transport.patches(); ++patch) {
        double sum = 0;
        for (std::uint32_t s = transport.first_sample[patch]; s < transport.first_sample[patch + 1]; ++s) {
            sum += largest(transport.weights[s]) * transport.rays;
        }
        largest_albedo = std::max(largest_albedo, sum);
    }
    const ColorOperator one_minus_transport = [&](std::span<const glm::dvec3> x, std::span<glm::dvec3> y) {
        std::fill(y.begin(), y.end(), glm::dvec3(0));
        add_transported(transport, x, y);
        for (std::size_t i = 0; i < y.size(); ++i) y[i] = x[i] - y[i];
    };
    Solution solution =
        solve_linear(one_minus_transport, direct, accuracy * (1 - std::min(largest_albedo, 0.99999)), most_sweeps);
    return {std::move(solution.x), solution.residual, solution.sweeps};
}

}  // namespace lightgrid
