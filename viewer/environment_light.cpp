#include "viewer/environment_light.h"

#include "core/environment_sh.h"
#include "core/near_names.h"
#include "core/sampling.h"
#include "core/sh.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

bool is_radiance_file(const fs::path& file) {
    const std::string extension = lower_case(file.extension().string());
    return extension == ".hdr" || extension == ".exr";
}

}  // namespace

Sh36 sample_environment(const Environment& environment, int samples, EnvironmentSampling sampling) {
    Sh36 sh{};
    if (sampling == EnvironmentSampling::by_brightness) {
        const std::vector<glm::vec3> coefficients = project_environment(environment, most_bands, samples);
        std::copy(coefficients.begin(), coefficients.end(), sh.begin());
        return sh;
    }
    std::array<double, sh_size(most_bands)> basis{};
    std::array<glm::dvec3, sh_size(most_bands)> sum{};
    for (const glm::vec3 direction : even_directions(static_cast<std::uint32_t>(samples))) {
        sh_basis(most_bands, glm::dvec3(direction), basis);
        const glm::dvec3 light(environment.radiance(direction));
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += basis[i] * light;
    }
    for (std::size_t i = 0; i < sh.size(); ++i) sh[i] = glm::vec3(4 * std::numbers::pi / samples * sum[i]);
    return sh;
}

Sh36 reference_environment(const Environment& environment) {
    return sample_environment(environment, all_environment_samples, EnvironmentSampling::by_brightness);
}

double irradiance_difference(const Sh36& sh, const Sh36& reference) {
    double difference = 0;
    double whole = 0;
    for (int band = 0; band < most_bands; ++band) {
        const double factor = cosine_lobe(band) * cosine_lobe(band);
        for (int m = -band; m <= band; ++m) {
            const auto i = static_cast<std::size_t>(sh_index(band, m));
            const glm::dvec3 d = glm::dvec3(sh[i]) - glm::dvec3(reference[i]);
            difference += factor * glm::dot(d, d);
            whole += factor * glm::dot(glm::dvec3(reference[i]), glm::dvec3(reference[i]));
        }
    }
    return whole > 0 ? std::sqrt(difference / whole) : 0;
}

glm::dmat3 turn_about_up(double deg) {
    return glm::dmat3(glm::rotate(glm::dmat4(1), glm::radians(deg), glm::dvec3(0, 1, 0)));
}

Sh36 turned(const Sh36& sh, double deg) {
    Sh36 result = sh;
    ShRotation(most_bands, turn_about_up(deg)).apply(std::span<glm::vec3>(result));
    return result;
}

std::shared_ptr<const LitVolume> volume_of(const Sh36& sh) {
    // Beyond its cell the nearest light holds, which is the same.
    Volume volume = make_volume({{glm::dvec3(-1), glm::dvec3(2), glm::ivec3(2)}}, most_bands);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] != ProbeState::valid) continue;
        std::copy(sh.begin(), sh.end(), volume.coefficients.begin() + static_cast<std::ptrdiff_t>(slot * sh.size()));
    }
    return std::make_shared<const LitVolume>(std::move(volume));
}

std::optional<fs::path> next_environment(const fs::path& file) {
    std::vector<fs::path> names;
    std::error_code problem;
    const fs::path folder = file.parent_path();
    for (const auto& entry : fs::directory_iterator(folder.empty() ? fs::path(".") : folder, problem)) {
        if (is_radiance_file(entry.path())) names.push_back(entry.path().filename());
    }
    std::sort(names.begin(), names.end());
    const auto next = std::upper_bound(names.begin(), names.end(), file.filename());
    const auto found = next == names.end() ? names.begin() : next;
    if (found == names.end() || *found == file.filename()) return {};
    return folder / *found;
}

}  // namespace lightgrid
