#include "viewer/environment_light.h"

#include "core/sampling.h"
#include "core/sh.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>
#include <vector>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

constexpr int reference_samples = 1 << 18;
constexpr std::uint64_t place_key = 0x1f0a;  // streams of random numbers
constexpr std::uint32_t choice_key = 0x2e1b;

/// Sums directions with what each stands for.
class Projection {
  public:
    void add(glm::vec3 direction, glm::vec3 light) {
        std::array<double, sh_size(most_bands)> basis{};
        sh_basis(most_bands, glm::dvec3(direction), basis);
        for (std::size_t i = 0; i < basis.size(); ++i) sum_[i] += basis[i] * glm::dvec3(light);
    }
    [[nodiscard]] Sh36 times(double factor) const {
        Sh36 sh{};
        for (std::size_t i = 0; i < sh.size(); ++i) sh[i] = glm::vec3(factor * sum_[i]);
        return sh;
    }

  private:
    std::array<glm::dvec3, sh_size(most_bands)> sum_{};
};

bool is_radiance_file(const fs::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension == ".hdr" || extension == ".exr";
}

}  // namespace

Sh36 sample_environment(const Environment& environment, int samples, EnvironmentSampling sampling) {
    Projection projection;
    const auto count = static_cast<std::uint32_t>(samples);
    if (sampling == EnvironmentSampling::evenly) {
        for (const glm::vec3 direction : even_directions(count)) {
            projection.add(direction, environment.radiance(direction));
        }
        return projection.times(4 * std::numbers::pi / samples);
    }
    for (std::uint32_t i = 0; i < count; ++i) {
        const glm::vec2 place = sobol_point(i, place_key);
        const float choice = sobol_point(shuffled_index(i, choice_key), choice_key).x;
        const Environment::Sample sample = environment.sample({choice, place.x, place.y});
        if (sample.pdf > 0) projection.add(sample.direction, sample.radiance / sample.pdf);
    }
    return projection.times(1.0 / samples);
}

Sh36 reference_environment(const Environment& environment) {
    return sample_environment(environment, reference_samples, EnvironmentSampling::by_brightness);
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
