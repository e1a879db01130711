#include "probes/gather_light.h"

#include "core/sampling.h"
#include "core/sh.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <array>

namespace lightgrid {
namespace {

constexpr std::uint32_t replicates = gather_replicates;

}  // namespace

std::uint64_t replicate_key(std::uint64_t seed, std::size_t point, std::uint32_t replicate) noexcept {
    return mix_bits(mix_bits(mix_bits(seed, 1), point), replicate);
}

glm::mat3 replicate_rotation(std::uint64_t key) noexcept {
    return random_rotation(mix_bits(key, 0));
}

PointLight::PointLight(int bands)
    : bands_(bands),
      coefficients_(static_cast<std::size_t>(sh_size(bands))),
      values_(replicates * values(bands), glm::dvec3(0)) {}

std::size_t PointLight::values(int bands) {
    return static_cast<std::size_t>(sh_size(bands)) + axis_normals.size();
}

void PointLight::add(std::uint32_t replicate, glm::vec3 direction, glm::dvec3 radiance) {
    std::array<float, static_cast<std::size_t>(sh_size(max_sh_bands))> basis;
    sh_basis(bands_, direction, std::span(basis.data(), coefficients_));
    glm::dvec3* value = values_.data() + replicate * values(bands_);
    for (std::size_t i = 0; i < coefficients_; ++i) value[i] += radiance * static_cast<double>(basis[i]);
}

void PointLight::set(std::uint32_t replicate, std::span<const glm::vec3> coefficients) {
    std::copy(coefficients.begin(), coefficients.end(),
              values_.begin() + static_cast<std::ptrdiff_t>(replicate * values(bands_)));
}

std::vector<Estimate> PointLight::estimates() {
    const std::size_t n = values(bands_);
    std::vector<glm::vec3> sh(coefficients_);
    for (std::uint32_t r = 0; r < replicates; ++r) {
        for (std::size_t i = 0; i < coefficients_; ++i) sh[i] = glm::vec3(values_[r * n + i]);
        for (std::size_t axis = 0; axis < axis_normals.size(); ++axis) {
            values_[r * n + coefficients_ + axis] = glm::dvec3(irradiance_from_sh(sh, axis_normals[axis]));
        }
    }
    std::vector<Estimate> result(n);
    for (std::size_t i = 0; i < n; ++i) {
        // From the first: no cancellation where all agree.
        glm::dvec3 sum(0);
        glm::dvec3 squares(0);
        for (std::uint32_t r = 1; r < replicates; ++r) {
            const glm::dvec3 deviation = values_[r * n + i] - values_[i];
            sum += deviation;
            squares += deviation * deviation;
        }
        result[i].mean = values_[i] + sum / double{replicates};
        const glm::dvec3 variance = (squares - sum * sum / double{replicates}) / double{replicates - 1};
        result[i].error = glm::sqrt(glm::max(variance, 0.0) / double{replicates});
    }
    return result;
}

GatherLight::GatherLight(const KeptGather& gather, const LightSeen& seen, int bands)
    : gather_(gather),
      seen_(seen),
      bands_(bands),
      coefficients_(static_cast<std::size_t>(sh_size(bands))),
      even_(even_directions(gather.rays)),
      basis_(even_.size() * coefficients_) {
    for (std::size_t i = 0; i < even_.size(); ++i) {
        sh_basis(bands, glm::dvec3(even_[i]), std::span(basis_).subspan(i * coefficients_, coefficients_));
    }
}

std::vector<Estimate> GatherLight::at(std::size_t point, std::span<const Estimate> other) const {
    PointLight light(bands_);
    for (std::uint32_t r = 0; r < replicates; ++r) light.set(r, from_rays(point, r));
    std::vector<Estimate> result = light.estimates();
    const auto add = [&](std::size_t i, glm::dvec3 mean, glm::dvec3 error) {
        result[i].mean += mean;
        result[i].error = glm::sqrt(result[i].error * result[i].error + error * error);
    };
    for (std::size_t s = 0; s < gather_.aimed.size(); ++s) {
        if (seen_.straight[s] == glm::vec3(0)) continue;
        const glm::dvec3 factor(seen_.straight[s]);
        for (std::size_t i = 0; i < result.size(); ++i) {
            const KeptEstimate& aimed = gather_.aimed[s][point * result.size() + i];
            add(i, factor * glm::dvec3(aimed.mean), factor * glm::dvec3(aimed.error));
        }
    }
    for (std::size_t i = 0; i < other.size(); ++i) add(i, other[i].mean, other[i].error);
    return result;
}

glm::vec3 GatherLight::light_at(std::uint32_t place, std::uint32_t ray, const glm::mat3& rotation) const {
    if (place == Transport::sky) return seen_.sky ? seen_.sky(rotation * even_[ray]) : glm::vec3(0);
    if (place >= RayEnd::emitter) return seen_.straight[place - RayEnd::emitter];
    return seen_.reflected.empty() ? glm::vec3(0) : seen_.reflected[place];
}

std::vector<glm::vec3> GatherLight::from_rays(std::size_t point, std::uint32_t replicate) const {
    const std::size_t set = point * replicates + replicate;
    const glm::mat3 rotation = replicate_rotation(replicate_key(gather_.seed, point, replicate));
    std::vector<glm::dvec3> sum(coefficients_, glm::dvec3(0));
    const auto add = [&](std::uint32_t ray, std::uint32_t place, glm::vec3 share) {
        const glm::dvec3 radiance(share * light_at(place, ray, rotation));
        const double* basis = basis_.data() + ray * coefficients_;
        for (std::size_t i = 0; i < coefficients_; ++i) sum[i] += radiance * basis[i];
    };
    const std::uint32_t* landed = gather_.landed.data() + set * gather_.rays;
    for (std::uint32_t i = 0; i < gather_.rays; ++i) {
        if (landed[i] != Transport::none) add(i, landed[i], glm::vec3(1));
    }
    for (std::uint64_t k = gather_.first_end[set]; k < gather_.first_end[set + 1]; ++k) {
        const RayEnd& end = gather_.ends[k];
        if (end.at != Transport::none) add(end.ray, end.at, end.share);
    }
    std::vector<glm::vec3> result;
    const double share = 4 * glm::pi<double>() / gather_.rays;
    for (const glm::dvec3& value : sum) result.emplace_back(share * value);
    ShRotation(bands_, glm::dmat3(rotation)).apply(result);
    return result;
}

}  // namespace lightgrid
