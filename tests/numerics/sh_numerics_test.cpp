#include "core/sh.h"
#include "tests/numerics/numerics_row.h"
#include "tests/sphere.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace lightgrid {
namespace {

using std::numbers::pi;

constexpr int bands = max_sh_bands;
constexpr int top = bands - 1;

/// Spherical harmonics as they are often written down: factorials, and Legendre functions that are normalised last.
template <typename T>
std::vector<T> naive_basis(glm::vec<3, T> d) {
    const auto factorial = [](int n) {
        T product = 1;
        for (int k = 2; k <= n; ++k) product *= static_cast<T>(k);
        return product;
    };
    const T phi = std::atan2(d.y, d.x);
    const T sine = std::sqrt(std::max(T(0), 1 - d.z * d.z));
    std::vector<T> values(sh_size(bands));
    T diagonal = 1;
    for (int m = 0; m < bands; ++m) {
        T before = 0;
        T legendre = diagonal;
        for (int l = m; l < bands; ++l) {
            const T scale = std::sqrt(T(2 * l + 1) / T(4 * pi) * factorial(l - m) / factorial(l + m));
            const T root2 = m > 0 ? std::sqrt(T(2)) : T(1);
            if (m > 0) values[sh_index(l, -m)] = root2 * scale * std::sin(T(m) * phi) * legendre;
            values[sh_index(l, m)] = root2 * scale * std::cos(T(m) * phi) * legendre;
            const T next = (T(2 * l + 1) * d.z * legendre - T(l + m) * before) / T(l - m + 1);
            before = legendre;
            legendre = next;
        }
        diagonal *= T(2 * m + 1) * sine;
    }
    return values;
}

/// The Legendre polynomial as the sum of its powers of z.
double power_sum_legendre(int l, double z) {
    double term = 1;  // binomial(l, k) binomial(2l - 2k, l) / 2^l, for k = 0
    for (int k = 1; k <= l; ++k) term *= (l + k) / (2.0 * k);
    double sum = 0;
    for (int k = 0; 2 * k <= l; ++k) {
        sum += term * std::pow(z, l - 2 * k);
        term *= -(l - 2.0 * k) * (l - 2 * k - 1) / (2.0 * (k + 1) * (2 * l - 2 * k - 1));
    }
    return sum;
}

/// The largest |4 pi / (2l + 1) sum_m Y_lm^2 - 1| of all bands, which is exactly 0.
template <typename T>
double addition_theorem_error(const std::vector<T>& basis) {
    double largest = 0;
    for (int l = 0; l < bands; ++l) {
        double sum = 0;
        for (int i = sh_size(l); i < sh_size(l + 1); ++i) sum += static_cast<double>(basis[i]) * basis[i];
        const double error = std::abs(4 * pi / (2 * l + 1) * sum - 1);
        if (!(error <= largest)) largest = error;  // NaN stays
    }
    return largest;
}

double norm(const std::vector<double>& c) {
    return std::sqrt(std::inner_product(c.begin(), c.end(), c.begin(), 0.0));
}

TEST(ShNumerics, BasisIsOrthonormalToDegree50) {
    // Function by function: its norm, and its product with every other of the same order, where errors do not cancel.
    const std::vector<QuadratureNode> nodes = sphere_quadrature(2 * top);
    std::vector<std::array<double, bands>> gram(sh_size(bands));  // (l, m) times (other, m)
    std::vector<double> basis(sh_size(bands));
    for (const auto& [direction, weight] : nodes) {
        sh_basis(bands, direction, std::span(basis));
        for (int l = 0; l < bands; ++l) {
            for (int m = -l; m <= l; ++m) {
                const double value = weight * basis[sh_index(l, m)];
                std::array<double, bands>& row = gram[sh_index(l, m)];
                for (int other = std::abs(m); other < bands; ++other) row[other] += value * basis[sh_index(other, m)];
            }
        }
    }
    double error = 0;
    for (int l = 0; l < bands; ++l) {
        for (int m = -l; m <= l; ++m) {
            for (int other = std::abs(m); other < bands; ++other) {
                const double wanted = l == other ? 1 : 0;
                error = std::fmax(error, std::abs(gram[sh_index(l, m)][other] - wanted));
            }
        }
    }
    numerics_row("SH to degree 50: Gram matrix, largest error", 0, error, error, 1e-12);
}

TEST(ShNumerics, AnalysisOfSynthesisReturnsTheCoefficients) {
    std::mt19937_64 random(1);
    const std::vector<double> c = random_numbers(sh_size(bands), random);
    std::vector<double> back(c.size());
    std::vector<double> basis(c.size());
    for (const auto& [direction, weight] : sphere_quadrature(2 * top)) {
        sh_basis(bands, direction, std::span(basis));
        const double value = weight * std::inner_product(c.begin(), c.end(), basis.begin(), 0.0);
        for (std::size_t i = 0; i < c.size(); ++i) back[i] += value * basis[i];
    }
    const double error = largest_difference(back, c);
    numerics_row("SH to degree 50: random coefficients, back from quadrature", 0, error, error, 1e-11);
}

TEST(ShNumerics, SquaresSumToOneInFloatAndDouble) {
    std::mt19937_64 random(2);
    double error = 0;
    double error_float = 0;
    double naive = 0;
    int naive_bad = 0;
    for (int i = 0; i < 100; ++i) {
        const glm::dvec3 d = random_direction(random);
        std::vector<double> basis(sh_size(bands));
        sh_basis(bands, d, std::span(basis));
        error = std::fmax(error, addition_theorem_error(basis));
        std::vector<float> single(sh_size(bands));
        sh_basis(bands, glm::vec3(d), std::span(single));
        error_float = std::fmax(error_float, addition_theorem_error(single));
        naive = std::fmax(naive, addition_theorem_error(naive_basis<double>(d)));
        const std::vector<float> naive_float = naive_basis<float>(glm::vec3(d));
        for (std::size_t k = 0; k < single.size(); ++k) {
            if (!(std::abs(naive_float[k] - basis[k]) < 1e-3)) ++naive_bad;
        }
    }
    numerics_row("SH to degree 50, double: sum of squares of a band, relative", 0, error, error, 1e-12,
                 fmt::format("factorials in double: {:.2g}", naive));
    numerics_row("SH to degree 50, float: sum of squares of a band, relative", 0, error_float, error_float, 1e-4,
                 fmt::format("factorials in float: {:.0f} % of the values wrong or not finite",
                             100.0 * naive_bad / (100 * sh_size(bands))));
}

TEST(ShNumerics, ValueAtThePoleIsExact) {
    std::vector<double> basis(sh_size(bands));
    sh_basis(bands, glm::dvec3(0, 0, 1), std::span(basis));
    const double exact = std::sqrt((2 * top + 1) / (4 * pi));
    const double ours = basis[sh_index(top, 0)];
    numerics_row("SH of degree 50 at the pole, absolute", exact, ours, std::abs(ours - exact), 1e-13,
                 fmt::format("sum of powers: {:.10g}", exact * power_sum_legendre(top, 1)));
}

TEST(ShNumerics, AThousandRotationsKeepNormAndCompose) {
    std::mt19937_64 random(3);
    const std::vector<double> c = random_numbers(sh_size(bands), random);
    std::vector<double> chained = c;
    std::vector<glm::vec3> chained_float(c.begin(), c.end());
    glm::dmat3 all(1);
    for (int i = 0; i < 1000; ++i) {
        const glm::dmat3 turn = random_rotation(random);
        const ShRotation rotation(bands, turn);
        rotation.apply(chained);
        rotation.apply(chained_float);
        all = turn * all;
    }
    std::vector<double> at_once = c;
    ShRotation(bands, all).apply(at_once);
    std::vector<double> from_float(c.size());
    std::transform(chained_float.begin(), chained_float.end(), from_float.begin(), [](glm::vec3 v) { return v.x; });

    const double drift = std::abs(norm(chained) / norm(c) - 1);
    const double naive_drift = std::abs(norm(from_float) / norm(c) - 1);
    numerics_row("1000 random rotations of 51 bands: norm, relative", norm(c), norm(chained), drift, 1e-11,
                 fmt::format("rounded to float each time: {:.2g}", naive_drift));
    const double error = largest_difference(chained, at_once);
    numerics_row("1000 random rotations of 51 bands against their product, largest", 0, error, error, 1e-9,
                 fmt::format("rounded to float each time: {:.2g}", largest_difference(from_float, at_once)));
}

}  // namespace
}  // namespace lightgrid
