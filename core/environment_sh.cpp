#include "core/environment_sh.h"

#include "core/sampling.h"
#include "core/sh.h"

#include <cstdint>

namespace lightgrid {
namespace {

constexpr std::uint64_t place_key = 0x1f0a;  // streams of random numbers
constexpr std::uint32_t choice_key = 0x2e1b;

}  // namespace

std::vector<glm::vec3> project_environment(const Environment& environment, int bands, int samples) {
    std::vector<double> basis(static_cast<std::size_t>(sh_size(bands)));
    std::vector<glm::dvec3> sum(basis.size(), glm::dvec3(0));
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(samples); ++i) {
        const glm::vec2 place = sobol_point(i, place_key);
        const float choice = sobol_point(shuffled_index(i, choice_key), choice_key).x;
        const Environment::Sample sample = environment.sample({choice, place.x, place.y});
        if (!(sample.pdf > 0)) continue;
        sh_basis(bands, glm::dvec3(sample.direction), basis);
        const glm::dvec3 light(sample.radiance / sample.pdf);
        for (std::size_t k = 0; k < basis.size(); ++k) sum[k] += basis[k] * light;
    }
    std::vector<glm::vec3> coefficients;
    for (const glm::dvec3& value : sum) coefficients.emplace_back(1.0 / samples * value);
    return coefficients;
}

}  // namespace lightgrid
