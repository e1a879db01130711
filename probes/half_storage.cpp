#include "probes/half_storage.h"

#include "core/sh.h"

#include <Imath/half.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace lightgrid {
namespace {

// A brick's share of per-slot values; the last group of a probe list may be short.
template <typename T>
std::span<T> brick_of(std::span<T> values, std::size_t brick, std::size_t per_slot) {
    const std::size_t first = brick * probes_per_brick * per_slot;
    return values.subspan(first, std::min(values.size() - first, probes_per_brick * per_slot));
}

std::size_t brick_count(const Volume& volume) {
    return (volume.slots() + probes_per_brick - 1) / probes_per_brick;
}

glm::vec3 hypot(glm::vec3 a, glm::vec3 b) {
    const glm::dvec3 x(a);
    const glm::dvec3 y(b);
    return glm::sqrt(x * x + y * y);
}

glm::vec3 rounded(glm::vec3 value, float scale) {
    for (int c = 0; c < 3; ++c) value[c] = from_half(to_half(value[c], scale), scale);
    return value;
}

// A_l^2 / (4 pi) for each coefficient.
std::vector<double> irradiance_weights(int bands) {
    std::vector<double> weights;
    for (int l = 0; l < bands; ++l) {
        const double a = cosine_lobe(l);
        weights.insert(weights.end(), 2 * l + 1, a * a / (4 * std::numbers::pi));
    }
    return weights;
}

double squared(glm::dvec3 v) {
    return glm::dot(v, v);
}

}  // namespace

float half_scale(std::span<const glm::vec3> brick, std::span<const glm::vec3> more) noexcept {
    float largest = 0;
    for (const auto values : {brick, more}) {
        for (const glm::vec3& v : values) largest = std::max({largest, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    }
    if (largest == 0) return 1;
    int exponent = 0;
    // largest = fraction * 2^exponent. Rounding may carry 0.99999 to 1: counted now, or a second scale would differ.
    const float fraction = std::frexp(largest, &exponent);
    if (static_cast<float>(half(fraction)) == 1) ++exponent;
    // Kept normal, because tracing threads flush denormals.
    return std::ldexp(1.0F, std::clamp(exponent - 15, -126, 126));
}

std::uint16_t to_half(float value, float scale) noexcept {
    return half(value / scale).bits();
}

float from_half(std::uint16_t bits, float scale) noexcept {
    half value;
    value.setBits(bits);
    return static_cast<float>(value) * scale;
}

StorageChoice choose_storage(const Volume& volume) {
    const std::size_t size = volume.sh_size();
    const std::vector<double> weights = irradiance_weights(volume.bands);
    StorageChoice choice;
    double total = 0;
    std::size_t valid = 0;
    for (std::size_t b = 0; b < brick_count(volume); ++b) {
        const auto coefficients = brick_of(std::span(volume.coefficients), b, size);
        const auto errors = brick_of(std::span(volume.errors), b, size);
        const float scale = half_scale(coefficients);
        double storage = 0;
        double noise = 0;
        for (std::size_t i = 0; i < coefficients.size(); ++i) {
            if (!is_valid(volume.states[b * probes_per_brick + i / size])) continue;
            const double weight = weights[i % size];
            storage += weight * squared(glm::dvec3(rounded(coefficients[i], scale)) - glm::dvec3(coefficients[i]));
            noise += weight * squared(errors[i]);
            if (i % size == 0) ++valid;
        }
        total += storage;
        if (storage > 0) {
            const double share = noise > 0 ? std::sqrt(storage / noise) : std::numeric_limits<double>::infinity();
            choice.worst_share = std::max(choice.worst_share, share);
        }
    }
    choice.half = choice.worst_share <= max_storage_share;
    if (valid > 0) choice.irradiance_rms = std::sqrt(total / (3.0 * static_cast<double>(valid)));
    return choice;
}

void store_as_half(Volume& volume) {
    const std::size_t size = volume.sh_size();
    std::vector<glm::vec3> change(size);
    for (std::size_t b = 0; b < brick_count(volume); ++b) {
        const auto coefficients = brick_of(std::span(volume.coefficients), b, size);
        const auto errors = brick_of(std::span(volume.errors), b, size);
        const auto axis_errors = brick_of(std::span(volume.axis_errors), b, axis_normals.size());
        const float scale = half_scale(coefficients);
        for (std::size_t p = 0; p < coefficients.size() / size; ++p) {
            for (std::size_t i = 0; i < size; ++i) {
                glm::vec3& value = coefficients[p * size + i];
                glm::vec3& error = errors[p * size + i];
                const glm::vec3 stored = rounded(value, scale);
                change[i] = stored - value;
                error = hypot(error, change[i]);
                value = stored;
            }
            for (std::size_t a = 0; a < axis_normals.size(); ++a) {
                glm::vec3& error = axis_errors[p * axis_normals.size() + a];
                error = hypot(error, irradiance_from_sh(change, axis_normals[a]));
            }
        }
        const float error_scale = half_scale(errors, axis_errors);
        for (glm::vec3& error : errors) error = rounded(error, error_scale);
        for (glm::vec3& error : axis_errors) error = rounded(error, error_scale);
        for (Layer& layer : volume.layers) {
            const auto part = brick_of(std::span(layer.coefficients), b, size);
            const float part_scale = half_scale(part);
            for (glm::vec3& value : part) value = rounded(value, part_scale);
        }
    }
    volume.half = true;
}

}  // namespace lightgrid
