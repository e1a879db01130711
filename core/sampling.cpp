#include "core/sampling.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lightgrid {

std::vector<glm::vec3> even_directions(std::uint32_t count) {
    const double golden = glm::golden_ratio<double>() - 1;
    std::vector<glm::vec3> directions;
    directions.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const double y = 1 - (2.0 * i + 1) / count;
        const double radius = std::sqrt((1 - y) * (1 + y));
        const double turns = i * golden;
        const double phi = glm::two_pi<double>() * (turns - std::floor(turns));
        directions.emplace_back(radius * std::cos(phi), y, radius * std::sin(phi));
    }
    return directions;
}

glm::mat3 random_rotation(std::uint64_t key) noexcept {
    RandomStream random(key);
    const double u = random.next();
    const glm::dvec2 angle = glm::two_pi<double>() * glm::dvec2(random.next2());
    const double a = std::sqrt(1 - u);
    const double b = std::sqrt(u);
    return glm::mat3(glm::mat3_cast(
        glm::dquat(b * std::cos(angle.y), a * std::sin(angle.x), a * std::cos(angle.x), b * std::sin(angle.y))));
}

std::vector<glm::vec3> turned(std::span<const glm::vec3> directions, const glm::mat3& rotation) {
    std::vector<glm::vec3> result;
    result.reserve(directions.size());
    for (const glm::vec3& direction : directions) result.push_back(rotation * direction);
    return result;
}

glm::vec3 sphere_direction(glm::vec2 u) noexcept {
    const float y = 1 - 2 * u.x;
    const float radius = std::sqrt(std::max(0.0F, 4 * u.x * (1 - u.x)));  // sqrt(1 - y^2) without cancellation
    const float phi = glm::two_pi<float>() * u.y;
    return {radius * std::cos(phi), y, radius * std::sin(phi)};
}

glm::vec3 cosine_direction(glm::vec3 normal, glm::vec2 u) noexcept {
    // Orthonormal frame without branches on the axis: Duff et al., "Building an Orthonormal Basis, Revisited", 2017.
    const float sign = std::copysign(1.0F, normal.z);
    const float a = -1 / (sign + normal.z);
    const float b = normal.x * normal.y * a;
    const glm::vec3 tangent(1 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x);
    const glm::vec3 bitangent(b, sign + normal.y * normal.y * a, -normal.y);

    const float radius = std::sqrt(u.x);
    const float phi = glm::two_pi<float>() * u.y;
    const float height = std::sqrt(1 - u.x);  // u.x <= 1 - 2^-24, so never zero
    return radius * std::cos(phi) * tangent + radius * std::sin(phi) * bitangent + height * normal;
}

glm::vec2 triangle_point(glm::vec2 u) noexcept {
    const float root = std::sqrt(u.x);
    return {root * (1 - u.y), root * u.y};
}

SphericalTriangle::SphericalTriangle(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) noexcept
    : a_(glm::normalize(a)), b_(glm::normalize(b)), cos_ab_(glm::dot(a_, b_)) {
    const glm::dvec3 to_c = glm::normalize(c);
    const double volume = std::abs(glm::dot(a_, glm::cross(b_, to_c)));
    const double cos_ac = glm::dot(a_, to_c);
    const double cos_bc = glm::dot(b_, to_c);
    solid_angle_ = 2 * std::atan2(volume, 1 + cos_ab_ + cos_bc + cos_ac);
    // Sine and cosine of the angle at a, both times the sines of the sides that meet there.
    const double cosine = cos_bc - cos_ab_ * cos_ac;
    const double length = std::hypot(cosine, volume);
    cos_a_ = cosine / length;
    sin_a_ = volume / length;
    towards_c_ = glm::normalize(to_c - cos_ac * a_);
}

glm::dvec3 SphericalTriangle::sample(glm::vec2 u) const noexcept {
    // The corner on the side a-c that cuts off a triangle a-b-corner of the share u.x.
    const double area = u.x * solid_angle_;
    const double s = std::sin(area) * cos_a_ - std::cos(area) * sin_a_;
    const double t = std::cos(area) * cos_a_ + std::sin(area) * sin_a_;
    const double p = t - cos_a_;
    const double q = s + sin_a_ * cos_ab_;
    const double below = (q * s + p * t) * sin_a_;
    const double cosine = below != 0 ? std::clamp(((q * t - p * s) * cos_a_ - q) / below, -1.0, 1.0) : 1.0;
    const glm::dvec3 corner = cosine * a_ + std::sqrt(1 - cosine * cosine) * towards_c_;
    // On the arc from b to there.
    const double cos_b_corner = glm::dot(corner, b_);
    const double z = 1 - u.y * (1 - cos_b_corner);
    const glm::dvec3 across = corner - cos_b_corner * b_;
    const double length = glm::length(across);
    return length > 0 ? z * b_ + (std::sqrt(std::max(0.0, 1 - z * z)) / length) * across : b_;
}

AliasTable::AliasTable(std::span<const double> weights) : bins_(weights.size()) {
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    if (!(sum > 0)) {
        bins_.clear();
        return;
    }
    const auto count = static_cast<std::uint32_t>(weights.size());
    std::vector<double> share(count);  // 1 on average
    std::vector<std::uint32_t> small;
    std::vector<std::uint32_t> large;
    for (std::uint32_t i = 0; i < count; ++i) {
        bins_[i].probability = static_cast<float>(weights[i] / sum);
        share[i] = weights[i] / sum * count;
        (share[i] < 1 ? small : large).push_back(i);
    }
    while (!small.empty() && !large.empty()) {
        const std::uint32_t low = small.back();
        const std::uint32_t high = large.back();
        small.pop_back();
        bins_[low].threshold = static_cast<float>(share[low]);
        bins_[low].alias = high;
        share[high] -= 1 - share[low];
        if (share[high] < 1) {
            large.pop_back();
            small.push_back(high);
        }
    }
    for (const std::uint32_t i : small) bins_[i].alias = i;  // left by rounding: shares of 1
    for (const std::uint32_t i : large) bins_[i].alias = i;
}

std::uint32_t AliasTable::sample(double u) const noexcept {
    const auto count = static_cast<std::uint32_t>(bins_.size());
    const double scaled = u * count;
    const std::uint32_t index = std::min(static_cast<std::uint32_t>(scaled), count - 1);
    return scaled - index < bins_[index].threshold ? index : bins_[index].alias;
}

}  // namespace lightgrid
