#include "core/sh.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

namespace lightgrid {
namespace {

constexpr double pi = std::numbers::pi;

/// Room for one number of each basis function.
template <typename T>
using Basis = std::array<T, sh_size(max_sh_bands)>;

// ---------------------------------------------------------------------------------------------------------- Basis

/// std::sqrt at compile time, right to a last place or two: Newton's method from above falls until it has arrived.
constexpr double square_root(double x) {
    if (x == 0) return 0;
    double root = std::max(x, 1.0);
    for (double next = 0.5 * (root + x / root); next < root; next = 0.5 * (root + x / root)) root = next;
    return root;
}

/// With P_lm the Legendre function, scaled so that Y_lm is orthonormal and divided by sin^m:
///
///   P_mm = diagonal[m],   P_(l+1)m = a[m][l] z P_lm - b[m][l] P_(l-1)m
///
///   a = sqrt((4k^2 - 1) / (k^2 - m^2)),   b = sqrt((2k + 1) (l^2 - m^2) / ((2k - 3) (k^2 - m^2))),   k = l + 1
template <typename T>
struct Recurrence {
    std::array<T, max_sh_bands> diagonal{};
    std::array<std::array<T, max_sh_bands>, max_sh_bands> a{};
    std::array<std::array<T, max_sh_bands>, max_sh_bands> b{};

    constexpr Recurrence() {
        double squared = 1 / (4 * pi);
        for (int m = 0; m < max_sh_bands; ++m) {
            if (m > 0) squared *= (2.0 * m + 1) / (2.0 * m);
            if (m == 1) squared *= 2;  // sine and cosine have half the mean square of 1
            diagonal[m] = static_cast<T>(square_root(squared));
            for (int l = m; l < max_sh_bands; ++l) {
                const double k = l + 1;
                const double k2_m2 = k * k - m * m;
                a[m][l] = static_cast<T>(square_root((4 * k * k - 1) / k2_m2));
                if (l > m) b[m][l] = static_cast<T>(square_root((2 * k + 1) * (l * l - m * m) / ((2 * k - 3) * k2_m2)));
            }
        }
    }
};

template <typename T>
constexpr Recurrence<T> recurrence;

/// |d|^l Y_lm(d / |d|): homogeneous polynomials in x, y, z, with neither division nor angle.
template <typename T>
[[gnu::always_inline]] inline void solid_harmonics(int bands, glm::vec<3, T> d, T* values) {
    const Recurrence<T>& r = recurrence<T>;
    const T length2 = d.x * d.x + d.y * d.y + d.z * d.z;
    T cosine = 1;  // real and imaginary part of (x + iy)^m
    T sine = 0;
#pragma GCC unroll 5
    for (int m = 0; m < bands; ++m) {
        T legendre = r.diagonal[m];
        T before = 0;
#pragma GCC unroll 5
        for (int l = m; l < bands; ++l) {
            if (m > 0) values[sh_index(l, -m)] = legendre * sine;
            values[sh_index(l, m)] = legendre * cosine;
            T next = r.a[m][l] * d.z * legendre;
            if (l > m) next -= r.b[m][l] * length2 * before;
            before = legendre;
            legendre = next;
        }
        const T next = d.x * cosine - d.y * sine;
        sine = d.x * sine + d.y * cosine;
        cosine = next;
    }
}

template <typename T>
void basis_at(int bands, glm::vec<3, T> direction, T* values) noexcept {
    assert(1 <= bands && bands <= max_sh_bands);
    assert(!(std::abs(glm::length(direction) - 1) > 1.01e-4));
    switch (bands) {  // a constant lets the compiler unroll
        case 1:
            return solid_harmonics(1, direction, values);
        case 2:
            return solid_harmonics(2, direction, values);
        case 3:
            return solid_harmonics(3, direction, values);
        case 4:
            return solid_harmonics(4, direction, values);
        case 5:
            return solid_harmonics(5, direction, values);
        default:
            return solid_harmonics(bands, direction, values);
    }
}

[[nodiscard]] int checked_bands(std::size_t size) noexcept {
    const int bands = sh_bands(size);
    assert(1 <= bands && bands <= max_sh_bands && static_cast<std::size_t>(sh_size(bands)) == size);
    return bands;
}

template <typename T>
std::span<T> band_of(std::span<T> coefficients, int l) noexcept {
    return coefficients.subspan(sh_size(l), 2 * l + 1);
}

template <typename Value, typename T>
Value evaluate(std::span<const Value> coefficients, glm::vec<3, T> direction) noexcept {
    Basis<T> basis;
    basis_at(checked_bands(coefficients.size()), direction, basis.data());
    Value sum(0);
    for (std::size_t i = 0; i < coefficients.size(); ++i) sum += coefficients[i] * basis[i];
    return sum;
}

// ----------------------------------------------------------------------------------------------------- Irradiance

constexpr double lobe(int band) {
    if (band == 1) return 2 * pi / 3;
    if (band % 2 == 1) return 0;
    double a = pi;
    for (int l = 2; l <= band; l += 2) a *= -(l - 3.0) / (l + 2.0);
    return a;
}

constexpr auto lobes = [] {
    std::array<double, max_sh_bands> a{};
    for (int l = 0; l < max_sh_bands; ++l) a[l] = lobe(l);
    return a;
}();

[[gnu::always_inline]] inline glm::vec3 irradiance(int bands, std::span<const glm::vec3> radiance, glm::vec3 normal) {
    Basis<float> basis;
    solid_harmonics(bands, normal, basis.data());
    glm::vec3 sum(0);
#pragma GCC unroll 3
    for (int l = 0; l < bands; ++l) {
        glm::vec3 band(0);
#pragma GCC unroll 5
        for (int i = sh_size(l); i < sh_size(l + 1); ++i) band += radiance[i] * basis[i];
        sum += band * static_cast<float>(lobes[l]);
    }
    return sum;
}

// ----------------------------------------------------------------------------------------------------- Projection

/// No point of the sphere is further than covering / sqrt(count) from a spherical Fibonacci set of 16 points or more;
/// 2.74 was measured on Voronoi diagrams for 16 to 41,616 points.
constexpr double covering = 2.8;

/// Point i of a spherical Fibonacci set: equal steps in z, steps by the golden angle around it.
glm::dvec3 fibonacci_direction(int i, int count) noexcept {
    const double z = 1 - (2.0 * i + 1) / count;
    const double turns = i / std::numbers::phi;
    const double angle = 2 * pi * (turns - std::floor(turns));
    const double radius = std::sqrt(1 - z * z);
    return {radius * std::cos(angle), radius * std::sin(angle), z};
}

template <typename Value, typename Sum>
std::vector<Value> project(int bands, const std::function<Value(glm::dvec3)>& function, int samples) {
    assert(samples > 0);
    Basis<double> basis;
    std::vector<Sum> sums(sh_size(bands), Sum(0));
    for (int s = 0; s < samples; ++s) {
        const glm::dvec3 direction = fibonacci_direction(s, samples);
        const Sum value(function(direction));
        basis_at(bands, direction, basis.data());
        for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += value * basis[i];
    }
    std::vector<Value> coefficients(sums.size());
    const double solid_angle = 4 * pi / samples;
    for (std::size_t i = 0; i < sums.size(); ++i) coefficients[i] = Value(sums[i] * solid_angle);
    return coefficients;
}

// --------------------------------------------------------------------------------------------------- Band by band

double scaled(double value, double factor) {
    return value * factor;
}

glm::vec3 scaled(glm::vec3 value, double factor) {
    return glm::vec3(glm::dvec3(value) * factor);
}

/// Multiplies band l by factor(l).
template <typename Value, typename Factor>
void scale_bands(std::span<Value> coefficients, const Factor& factor) noexcept {
    const int bands = checked_bands(coefficients.size());
    for (int l = 0; l < bands; ++l) {
        const double f = factor(l);
        for (Value& value : band_of(coefficients, l)) value = scaled(value, f);
    }
}

// ------------------------------------------------------------------------------------------------------- Rotation

/// The sum of (2k + 1)^2 over k < l: where block l begins.
constexpr std::size_t block_start(std::size_t l) {
    return l * (4 * l * l - 1) / 3;
}

/// One block of a rotation; row m and column n run from -l to l.
template <typename T>
struct Block {
    T* numbers;
    int l;

    T& at(int m, int n) const { return numbers[(m + l) * (2 * l + 1) + n + l]; }
};

/// Row m of block l: the sum that Ivanic and Ruedenberg write as u U + v V + w W, each a product of the block of band 1
/// and a row of the block of band l - 1. What depends on the column alone is divided out last.
void rotation_row(Block<const double> one, Block<const double> previous, Block<double> block, int m) {
    const int l = block.l;
    // Adds weight * P_i(mu, n) for all n.
    const auto add = [&](double weight, int i, int mu) {
        const double first = previous.at(mu, -(l - 1));
        const double last = previous.at(mu, l - 1);
        block.at(m, -l) += weight * (one.at(i, 1) * first + one.at(i, -1) * last);
        for (int n = -(l - 1); n < l; ++n) block.at(m, n) += weight * one.at(i, 0) * previous.at(mu, n);
        block.at(m, l) += weight * (one.at(i, 1) * last - one.at(i, -1) * first);
    };
    const int k = std::abs(m);
    const int sign = m < 0 ? -1 : 1;
    const double v = 0.5 * std::sqrt(static_cast<double>(l + k - 1) * (l + k));
    const double w = -0.5 * std::sqrt(static_cast<double>(l - k - 1) * (l - k));
    if (k < l) add(std::sqrt(static_cast<double>(l + m) * (l - m)), 0, m);
    if (m == 0) {
        const double both = -std::sqrt(2.0) * v;
        add(both, 1, 1);
        add(both, -1, -1);
    } else if (k == 1) {
        add(std::sqrt(2.0) * v, m, 0);
    } else {
        add(v, 1, m - sign);
        add(-sign * v, -1, sign - m);
    }
    if (m != 0 && k < l - 1) {
        add(w, 1, m + sign);
        add(sign * w, -1, -sign - m);
    }
    for (int n = -l; n <= l; ++n) {
        const int column = std::abs(n) < l ? (l + n) * (l - n) : 2 * l * (2 * l - 1);
        block.at(m, n) /= std::sqrt(static_cast<double>(column));
    }
}

/// The orthonormal matrix beside a nearly orthonormal one (Gram-Schmidt), of the same handedness.
glm::dmat3 orthonormalised(const glm::dmat3& matrix) {
    const glm::dvec3 x = glm::normalize(matrix[0]);
    const glm::dvec3 y = glm::normalize(matrix[1] - glm::dot(matrix[1], x) * x);
    const glm::dvec3 z = glm::cross(x, y);
    return {x, y, glm::determinant(matrix) < 0 ? -z : z};
}

template <typename Sum, typename Value>
void rotate(std::span<const double> blocks, std::span<Value> coefficients) noexcept {
    const int bands = checked_bands(coefficients.size());
    constexpr int widest = 2 * max_sh_bands - 1;
    std::array<Sum, widest> band;  // before it is turned
    for (int l = 1; l < bands; ++l) {
        const int width = 2 * l + 1;
        const std::span<Value> values = band_of(coefficients, l);
        const double* row = &blocks[block_start(l)];
        std::copy(values.begin(), values.end(), band.begin());
        for (int m = 0; m < width; ++m, row += width) {
            Sum sum(0);
            for (int n = 0; n < width; ++n) sum += row[n] * band[n];
            values[m] = Value(sum);
        }
    }
}

// ------------------------------------------------------------------------------------------------------ Deringing

constexpr double margin = 1e-5;  // of the mean: what rounding to float may take from the lowest irradiance

struct Place {
    glm::dvec3 direction;
    double value;
};

/// Goes down from a place to a local minimum: Newton's method in the tangent plane with numerical derivatives, by steps
/// of at most `radius` that are only taken if they lead down, until one gains less than `tolerance`.
Place descend(std::span<const double> coefficients, Place place, double radius, double tolerance) {
    constexpr double h = 1e-3;  // curvature: rounding about 1e-16 / h^2, truncation (bands h)^2
    constexpr double least_radius = 1e-6;
    while (radius > least_radius) {
        const glm::dvec3 n = place.direction;
        const double value = place.value;
        const glm::dvec3 across = std::abs(n.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
        const glm::dvec3 u = glm::normalize(glm::cross(n, across));
        const glm::dvec3 v = glm::cross(n, u);
        const auto direction = [&](glm::dvec2 p) { return glm::normalize(n + p.x * u + p.y * v); };
        const auto at = [&](glm::dvec2 p) { return evaluate(coefficients, direction(p)); };

        const double left = at({-h, 0}), right = at({h, 0}), below = at({0, -h}), above = at({0, h});
        const double gu = (right - left) / (2 * h);
        const double gv = (above - below) / (2 * h);
        double uu = (left + right - 2 * value) / (h * h);
        double vv = (below + above - 2 * value) / (h * h);
        const double uv = (at({h, h}) + at({-h, -h}) + 2 * value - left - right - below - above) / (2 * h * h);

        // Where the surface is no bowl, the curvature that makes it one is added.
        const double spread = std::hypot(0.5 * (uu - vv), uv);
        const double least = 0.5 * (uu + vv) - spread;
        const double added = std::max(0.0, 1e-3 * (spread + std::abs(uu + vv)) - least);
        uu += added;
        vv += added;

        glm::dvec2 step = glm::dvec2(uv * gv - vv * gu, uv * gu - uu * gv) / (uu * vv - uv * uv);
        if (glm::length(step) > radius) step *= radius / glm::length(step);
        const double gain = value - at(step);
        if (gain > 0) {
            place = {direction(step), value - gain};
            if (gain < tolerance) break;
        } else {
            radius = 0.25 * glm::length(step);
        }
    }
    return place;
}

/// No second derivative along a great circle is larger: by the addition theorem a band f_l has at most
/// |f_l| sqrt((2l + 1) / 4pi) sqrt(P), |f_l| being the norm of its coefficients and P the fourth derivative of
/// P_l(cos t) at t = 0, which Legendre's equation gives as q (3q - 2) / 8, q = l (l + 1).
double largest_curvature(std::span<const double> coefficients) {
    double sum = 0;
    for (int l = 1; l < sh_bands(coefficients.size()); ++l) {
        const std::span<const double> band = band_of(coefficients, l);
        const double q = l * (l + 1.0);
        const double norm2 = std::inner_product(band.begin(), band.end(), band.begin(), 0.0);
        sum += std::sqrt(norm2 * (2 * l + 1) / (4 * pi) * q * (3 * q - 2) / 8);
    }
    return sum;
}

/// A direction in which the function is negative, at a local minimum, if there is one.
///
/// The point of a Fibonacci set that is nearest to the lowest point of the function is no further from it than
/// `distance` and so, by the curvature, no more than `reach` above it: every point that low is followed down.
std::optional<glm::dvec3> negative_direction(std::span<const double> coefficients) {
    const double mean = coefficients[0] * recurrence<double>.diagonal[0];
    const double curvature = largest_curvature(coefficients);
    if (!std::isfinite(mean + curvature)) return std::nullopt;

    // As many points as bring the reach down to an eighth of the mean, within reason.
    const double wanted = 0.5 * curvature * covering * covering / (mean / 8) + 16;
    const double most = 64.0 * static_cast<double>(coefficients.size());
    const int count = static_cast<int>(wanted >= 16 && wanted < most ? wanted : most);
    const double distance = covering / std::sqrt(count);
    const double reach = 0.5 * curvature * distance * distance;
    std::vector<double> values(count);
    for (int i = 0; i < count; ++i) values[i] = evaluate(coefficients, fibonacci_direction(i, count));

    const auto follow = [&](int i) -> std::optional<glm::dvec3> {
        const Place start{fibonacci_direction(i, count), values[i]};
        const Place lowest = descend(coefficients, start, distance, 1e-3 * margin * mean);
        return lowest.value < 0 ? std::optional(lowest.direction) : std::nullopt;
    };
    const auto least = std::min_element(values.begin(), values.end()) - values.begin();  // mostly settles the matter
    std::optional<glm::dvec3> found = follow(static_cast<int>(least));
    for (int i = 0; i < count && !found; ++i) {
        if (values[i] < reach) found = follow(i);
    }
    return found;
}

/// The least strength, from `strength` up, with which the function is `floor` in a direction where it is negative.
///
/// bands  what each band adds to the function there; the first is above `floor`
double raise_strength(std::span<const double> bands, ShWindow window, double strength, double floor) {
    const auto is_low = [&](double s) {
        double sum = -floor;
        for (std::size_t l = 0; l < bands.size(); ++l) sum += window_factor(window, static_cast<int>(l), s) * bands[l];
        return sum < 0;
    };
    double low = strength;
    double high = std::max(2 * strength, 1e-3);
    while (is_low(high)) {
        low = high;
        high *= 2;
    }
    while (high - low > 1e-9 * high) {
        const double middle = 0.5 * (low + high);
        (is_low(middle) ? low : high) = middle;
    }
    return high;
}

/// The least strength, from `strength` up, with which a function of positive mean is nowhere negative.
///
/// Each turn takes a direction where it is negative and the strength that this direction asks for. No weaker window can
/// do, so the strength comes from below and stops at the least.
double least_strength(const std::vector<double>& coefficients, ShWindow window, double strength) {
    std::vector<double> windowed;
    std::vector<double> bands(sh_bands(coefficients.size()));
    Basis<double> basis;
    while (true) {
        windowed = coefficients;
        window_sh(windowed, window, strength);
        const std::optional<glm::dvec3> direction = negative_direction(windowed);
        if (!direction) return strength;
        basis_at(static_cast<int>(bands.size()), *direction, basis.data());
        for (int l = 0; l < static_cast<int>(bands.size()); ++l) {
            const std::span<const double> band = band_of(std::span(coefficients), l);
            bands[l] = std::inner_product(band.begin(), band.end(), &basis[sh_size(l)], 0.0);
        }
        strength = raise_strength(bands, window, strength, margin * bands[0]);
    }
}

}  // namespace

void sh_basis(int bands, glm::vec3 direction, std::span<float> values) noexcept {
    assert(checked_bands(values.size()) == bands);
    basis_at(bands, direction, values.data());
}

void sh_basis(int bands, glm::dvec3 direction, std::span<double> values) noexcept {
    assert(checked_bands(values.size()) == bands);
    basis_at(bands, direction, values.data());
}

glm::vec3 evaluate_sh(std::span<const glm::vec3> coefficients, glm::vec3 direction) noexcept {
    return evaluate(coefficients, direction);
}

double evaluate_sh(std::span<const double> coefficients, glm::dvec3 direction) noexcept {
    return evaluate(coefficients, direction);
}

std::vector<glm::vec3> project_to_sh(int bands, const std::function<glm::vec3(glm::dvec3)>& function, int samples) {
    return project<glm::vec3, glm::dvec3>(bands, function, samples);
}

std::vector<double> project_to_sh(int bands, const std::function<double(glm::dvec3)>& function, int samples) {
    return project<double, double>(bands, function, samples);
}

std::vector<glm::vec3> delta_light_sh(int bands, glm::dvec3 towards_light, glm::vec3 illuminance) {
    Basis<double> basis;
    basis_at(bands, towards_light, basis.data());
    std::vector<glm::vec3> coefficients(sh_size(bands));
    for (std::size_t i = 0; i < coefficients.size(); ++i) coefficients[i] = scaled(illuminance, basis[i]);
    return coefficients;
}

double cosine_lobe(int band) noexcept {
    assert(band >= 0);
    return lobe(band);
}

void convolve_with_cosine(std::span<glm::vec3> coefficients) noexcept {
    scale_bands(coefficients, cosine_lobe);
}

void convolve_with_cosine(std::span<double> coefficients) noexcept {
    scale_bands(coefficients, cosine_lobe);
}

glm::vec3 irradiance_from_sh(std::span<const glm::vec3> radiance, glm::vec3 normal) noexcept {
    return radiance.size() == 9 ? irradiance(3, radiance, normal)
                                : irradiance(checked_bands(radiance.size()), radiance, normal);
}

ShRotation::ShRotation(int bands, const glm::dmat3& rotation) : bands_(bands), blocks_(block_start(bands)) {
    assert(1 <= bands && bands <= max_sh_bands);
    const glm::dmat3 matrix = orthonormalised(rotation);
    blocks_[0] = 1;
    if (bands == 1) return;

    const Block<double> one{&blocks_[block_start(1)], 1};
    constexpr std::array axis{1, 2, 0};  // m = -1, 0, 1 are y, z, x
    for (int m = -1; m <= 1; ++m) {
        for (int n = -1; n <= 1; ++n) one.at(m, n) = matrix[axis[n + 1]][axis[m + 1]];
    }
    for (int l = 2; l < bands; ++l) {
        const Block<const double> previous{&blocks_[block_start(l - 1)], l - 1};
        for (int m = -l; m <= l; ++m) rotation_row({one.numbers, 1}, previous, {&blocks_[block_start(l)], l}, m);
    }
}

void ShRotation::apply(std::span<glm::vec3> coefficients) const noexcept {
    assert(coefficients.size() <= static_cast<std::size_t>(sh_size(bands_)));
    rotate<glm::dvec3>(std::span(blocks_), coefficients);
}

void ShRotation::apply(std::span<double> coefficients) const noexcept {
    assert(coefficients.size() <= static_cast<std::size_t>(sh_size(bands_)));
    rotate<double>(std::span(blocks_), coefficients);
}

double window_factor(ShWindow window, int band, double strength) noexcept {
    assert(band >= 0 && strength >= 0);
    const double x = band * strength;
    const double laplacian = static_cast<double>(band) * (band + 1);
    switch (window) {
        case ShWindow::hann:
            return x < 1 ? 0.5 * (1 + std::cos(pi * x)) : 0;
        case ShWindow::lanczos:
            return x == 0 ? 1 : x < 1 ? std::sin(pi * x) / (pi * x) : 0;
        case ShWindow::laplacian:
            return 1 / (1 + strength * laplacian * laplacian);
        case ShWindow::poisson:
            break;
    }
    return std::exp(-x);
}

void window_sh(std::span<glm::vec3> coefficients, ShWindow window, double strength) noexcept {
    scale_bands(coefficients, [&](int l) { return window_factor(window, l, strength); });
}

void window_sh(std::span<double> coefficients, ShWindow window, double strength) noexcept {
    scale_bands(coefficients, [&](int l) { return window_factor(window, l, strength); });
}

double dering_sh(std::span<glm::vec3> radiance, ShWindow window) {
    std::array<std::vector<double>, 3> irradiance;
    for (int c = 0; c < 3; ++c) {
        for (const glm::vec3& coefficient : radiance) irradiance[c].push_back(coefficient[c]);
        convolve_with_cosine(irradiance[c]);
        if (irradiance[c][0] <= 0 && negative_direction(irradiance[c])) {
            for (glm::vec3& coefficient : radiance) coefficient[c] = 0;
            std::fill(irradiance[c].begin(), irradiance[c].end(), 0.0);
        }
    }
    // A window that one channel asks for may, rarely, be one that another cannot bear: go round until all three can.
    double strength = 0;
    for (int channel = 0, content = 0; content < 3; channel = (channel + 1) % 3) {
        const double needed = least_strength(irradiance[channel], window, strength);
        content = needed > strength ? 1 : content + 1;
        strength = needed;
    }
    if (strength > 0) window_sh(radiance, window, strength);
    return strength;
}

}  // namespace lightgrid
