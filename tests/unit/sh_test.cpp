#include "core/sh.h"

#include "tests/sphere.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <numeric>
#include <sstream>
#include <string>

namespace lightgrid {
namespace {

using std::numbers::pi;

constexpr double double_ulp = 2.3e-16;
constexpr double float_ulp = 1.2e-7;

template <typename T = double>
std::vector<T> basis_at(int bands, glm::vec<3, T> direction) {
    std::vector<T> values(sh_size(bands));
    sh_basis(bands, direction, std::span(values));
    return values;
}

/// The same coefficients in all three channels.
std::vector<glm::vec3> grey(const std::vector<double>& coefficients) {
    return {coefficients.begin(), coefficients.end()};
}

double norm2_of_band(const std::vector<double>& coefficients, int l) {
    double sum = 0;
    for (int i = sh_size(l); i < sh_size(l + 1); ++i) sum += coefficients[i] * coefficients[i];
    return sum;
}

/// Coefficients by quadrature that is exact if the function is made of at most `bands` bands itself.
template <typename Function>
std::vector<double> project_exactly(int bands, const Function& function) {
    std::vector<double> coefficients(sh_size(bands));
    std::vector<double> basis(sh_size(bands));
    for (const auto& [direction, weight] : sphere_quadrature(2 * bands)) {
        const double value = function(direction) * weight;
        sh_basis(bands, direction, std::span(basis));
        for (std::size_t i = 0; i < basis.size(); ++i) coefficients[i] += value * basis[i];
    }
    return coefficients;
}

/// Radiance 1 from the upper half (+Z), 0 from the lower.
std::vector<double> half_sky(int bands) {
    std::vector<double> coefficients(sh_size(bands));
    coefficients[0] = std::sqrt(pi);
    if (bands > 1) coefficients[2] = 0.5 * std::sqrt(3 * pi);
    return coefficients;  // bands 2, 4, ... are 0, and 3, 5, ... do not count for irradiance
}

std::vector<glm::vec3> directions(int count) {
    std::mt19937_64 random(7);
    std::vector<glm::vec3> all{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
    while (static_cast<int>(all.size()) < count) all.emplace_back(random_direction(random));
    return all;
}

// ---------------------------------------------------------------------------------------------------------- Basis

TEST(ShBasis, HasTheStatedSignsAndAxes) {
    const glm::dvec3 d = glm::normalize(glm::dvec3(1, -2, 3));
    const std::vector<double> y = basis_at(3, d);
    EXPECT_NEAR(y[0], 0.282095, 1e-6);
    EXPECT_NEAR(y[1], 0.488603 * d.y, 1e-6);
    EXPECT_NEAR(y[2], 0.488603 * d.z, 1e-6);
    EXPECT_NEAR(y[3], 0.488603 * d.x, 1e-6);
    EXPECT_NEAR(y[4], 1.092548 * d.x * d.y, 1e-6);
    EXPECT_NEAR(y[5], 1.092548 * d.y * d.z, 1e-6);
    EXPECT_NEAR(y[6], 0.315392 * (3 * d.z * d.z - 1), 1e-6);
    EXPECT_NEAR(y[7], 1.092548 * d.x * d.z, 1e-6);
    EXPECT_NEAR(y[8], 0.546274 * (d.x * d.x - d.y * d.y), 1e-6);
}

TEST(ShBasis, AgreesWithScipyToDegree30) {
    std::ifstream file(LIGHTGRID_TEST_DIR "/sh_table.csv");
    std::string line;
    std::string cell;
    ASSERT_TRUE(std::getline(file, line));
    std::istringstream header(line);
    std::getline(header, cell, ',');
    std::getline(header, cell, ',');
    std::vector<std::vector<double>> ours;
    while (std::getline(header, cell, ',')) {
        glm::dvec3 direction;
        ASSERT_TRUE(std::istringstream(cell) >> direction.x >> direction.y >> direction.z);
        ours.push_back(basis_at(31, direction));
    }
    ASSERT_EQ(ours.size(), 8U);

    int rows = 0;
    for (; std::getline(file, line); ++rows) {
        std::istringstream row(line);
        int l = 0;
        int m = 0;
        char comma = 0;
        ASSERT_TRUE(row >> l >> comma >> m);
        for (const std::vector<double>& values : ours) {
            double wanted = 0;
            ASSERT_TRUE(row >> comma >> wanted);
            EXPECT_NEAR(values[sh_index(l, m)], wanted, 1e-10) << "l " << l << ", m " << m;
        }
    }
    EXPECT_EQ(rows, 31 * 31);
}

// For coefficients c of independent normal numbers and the Gram matrix G, (G - I) c is as large as the entries of G -
// I.
TEST(ShBasis, IsOrthonormalToDegree50) {
    std::mt19937_64 random(1);
    for (int trial = 0; trial < 4; ++trial) {
        const std::vector<double> c = random_numbers(sh_size(max_sh_bands), random);
        const auto back = project_exactly(max_sh_bands, [&](glm::dvec3 d) { return evaluate_sh(c, d); });
        EXPECT_LT(largest_difference(back, c), 1e-12);
    }
}

TEST(ShBasis, SquaresOfABandSumToTheSameInEveryDirection) {
    for (const glm::dvec3 d : directions(50)) {
        const glm::dvec3 unit = glm::normalize(d);
        const std::vector<double> y = basis_at(max_sh_bands, unit);
        for (int l = 0; l < max_sh_bands; ++l) {
            EXPECT_NEAR(norm2_of_band(y, l) * 4 * pi / (2 * l + 1), 1, 1e-12) << "l " << l;
        }
    }
}

TEST(ShBasis, IsExactlyZonalAtThePoles) {
    for (const double z : {1.0, -1.0}) {
        const std::vector<double> y = basis_at(max_sh_bands, glm::dvec3(0, 0, z));
        for (int l = 0; l < max_sh_bands; ++l) {
            for (int m = -l; m <= l; ++m) {
                const double wanted = m == 0 ? std::sqrt((2 * l + 1) / (4 * pi)) * std::pow(z, l) : 0;
                EXPECT_NEAR(y[sh_index(l, m)], wanted, m == 0 ? 1e-12 : 0) << "l " << l << ", m " << m;
            }
        }
    }
}

TEST(ShBasis, IsFiniteAndContinuousBesideThePoles) {
    const std::vector<float> pole = basis_at(max_sh_bands, glm::vec3(0, 0, 1));
    for (const float x : {1e-40F, 1e-20F, 1e-7F}) {
        const std::vector<float> beside = basis_at(max_sh_bands, glm::vec3(x, -x, 1));
        for (std::size_t i = 0; i < pole.size(); ++i) {
            // The slope of a basis function is at most its largest value, below 3, times its degree, 50.
            EXPECT_NEAR(beside[i], pole[i], 150 * std::sqrt(2.0F) * x) << "index " << i << ", x " << x;
        }
    }
}

// Each of l steps of the recurrence rounds a number that is at most sqrt((2l + 1) / (2 pi)).
TEST(ShBasis, FloatAgreesWithDouble) {
    for (const glm::vec3 d : directions(200)) {
        const std::vector<float> single = basis_at(max_sh_bands, d);
        const std::vector<double> twice = basis_at(max_sh_bands, glm::dvec3(d));
        for (int l = 0; l < max_sh_bands; ++l) {
            const double tolerance = 4 * float_ulp * (l + 1) * std::sqrt((2 * l + 1) / (2 * pi));
            for (int i = sh_size(l); i < sh_size(l + 1); ++i) EXPECT_NEAR(single[i], twice[i], tolerance) << "l " << l;
        }
    }
}

TEST(ShBasis, BandCountChangesNoBit) {
    for (const glm::vec3 d : directions(20)) {
        const std::vector<float> all = basis_at(max_sh_bands, d);
        for (int bands = 1; bands < max_sh_bands; ++bands) {
            const std::vector<float> some = basis_at(bands, d);
            EXPECT_TRUE(std::equal(some.begin(), some.end(), all.begin())) << bands << " bands";
        }
    }
}

TEST(ShBasis, ErrorInLengthOnlyScalesEachBand) {
    const glm::dvec3 d = glm::normalize(glm::dvec3(3, -1, 2));
    const double length = 1 + 1e-4;
    const std::vector<double> unit = basis_at(max_sh_bands, d);
    const std::vector<double> longer = basis_at(max_sh_bands, length * d);
    for (int l = 0; l < max_sh_bands; ++l) {
        for (int i = sh_size(l); i < sh_size(l + 1); ++i) {
            EXPECT_NEAR(longer[i], unit[i] * std::pow(length, l), 1e-12) << "l " << l;
        }
    }
}

TEST(ShBasis, BandsAndSizeAreInverse) {
    for (int bands = 1; bands <= max_sh_bands; ++bands) EXPECT_EQ(sh_bands(sh_size(bands)), bands);
}

// ----------------------------------------------------------------------------------------------------- Projection

TEST(ShProjection, UniformSkyOfRadianceOneHasL0OfTwoRootPi) {
    const auto sky = project_to_sh(3, [](glm::dvec3) { return 1.0; });
    EXPECT_NEAR(sky[0], 2 * std::sqrt(pi), 1e-12);
    for (int i = 1; i < 9; ++i) EXPECT_NEAR(sky[i], 0, 1e-5) << "index " << i;
}

TEST(ShProjection, FindsTheCoefficientsOfASmoothFunction) {
    std::mt19937_64 random(2);
    const std::vector<double> wanted = random_numbers(sh_size(5), random);
    const auto error = [&](int samples) {
        const auto function = [&](glm::dvec3 d) { return evaluate_sh(wanted, d); };
        return largest_difference(project_to_sh(5, function, samples), wanted);
    };
    EXPECT_LT(error(16384), 5e-5);
    EXPECT_LT(error(16384), error(1024) / 50);  // 16^1.5 = 64
}

TEST(ShProjection, FindsTheCoefficientsOfAHalfSky) {
    const auto sky = project_to_sh(3, [](glm::dvec3 d) { return d.z > 0 ? 1.0 : 0.0; });
    EXPECT_LT(largest_difference(sky, half_sky(3)), 1e-3);  // 16384^-0.75 = 7e-4
}

TEST(ShProjection, ProjectsColoursAsItProjectsNumbers) {
    const auto number = [](glm::dvec3 d) { return std::exp(d.x) * d.y; };
    const auto single = project_to_sh(4, number, 500);
    const auto colour = project_to_sh(
        4, [&](glm::dvec3 d) { return glm::vec3(1, 2, -3) * float(number(d)); }, 500);
    for (int i = 0; i < 16; ++i) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(colour[i][c], single[i] * glm::vec3(1, 2, -3)[c], 1e-6);
    }
}

TEST(ShEvaluation, SumsColoursAsItSumsNumbers) {
    std::mt19937_64 random(3);
    const std::vector<double> numbers = random_numbers(sh_size(6), random);
    const glm::dvec3 d = random_direction(random);
    EXPECT_NEAR(evaluate_sh(grey(numbers), glm::vec3(d)).y, evaluate_sh(numbers, d), 1e-5);
}

// ----------------------------------------------------------------------------------------------------- Irradiance

TEST(ShCosineLobe, HasTheKnownFactors) {
    constexpr std::array known{pi, 2 * pi / 3, pi / 4, 0.0, -pi / 24, 0.0, pi / 64, 0.0};
    for (int l = 0; l < 8; ++l) EXPECT_NEAR(cosine_lobe(l), known[l], 4 * double_ulp) << "l " << l;
}

// A_l = 2 pi integral_0^1 z P_l(z) dz, here as an integral over the sphere of half z^2 turned inside out: both halves
// of |z| P_l(z) are the same for even l, and it is smooth in z^2 alone, so Gauss needs the half itself.
TEST(ShCosineLobe, IsTheIntegralOfClampedCosineTimesLegendre) {
    for (int l = 0; l < max_sh_bands; ++l) {
        double integral = 0;
        for (const auto& [d, weight] : sphere_quadrature(2 * max_sh_bands)) {
            const double z = 0.5 * (1 + d.z);  // the nodes of [-1, 1], moved to [0, 1]
            integral += 0.5 * weight * z * std::legendre(l, z);
        }
        EXPECT_NEAR(cosine_lobe(l), integral, 1e-13) << "l " << l;
    }
}

TEST(ShIrradiance, UniformSkyOfRadianceOneGivesPi) {
    for (const int bands : {1, 2, 3, 5, max_sh_bands}) {
        std::vector<glm::vec3> sky(sh_size(bands), glm::vec3(0));
        sky[0] = glm::vec3(2 * std::sqrt(pi));
        for (const glm::vec3 n : directions(20)) EXPECT_NEAR(irradiance_from_sh(sky, n).g, pi, 4 * float_ulp * pi);
    }
}

TEST(ShIrradiance, HalfSkyGivesOnePlusCosineOverTwo) {
    for (const int bands : {2, 3, 4, 5, 9}) {
        for (const glm::vec3 n : directions(50)) {
            EXPECT_NEAR(irradiance_from_sh(grey(half_sky(bands)), n).g, pi * (1 + n.z) / 2, 8 * float_ulp * pi);
        }
    }
}

// Radiance max(z, 0): E = 2/3 (sin t + (pi - t) cos t), less the bands that are cut off.
TEST(ShIrradiance, CosineSkyGivesTheClosedForm) {
    std::vector<double> sky(sh_size(max_sh_bands));
    for (int l = 0; l < max_sh_bands; ++l) sky[sh_index(l, 0)] = cosine_lobe(l) * std::sqrt((2 * l + 1) / (4 * pi));
    double missing = 0;
    for (int l = max_sh_bands; l < 2000; ++l) missing += cosine_lobe(l) * cosine_lobe(l) * (2 * l + 1) / (4 * pi);
    ASSERT_LT(missing, 1e-5);
    convolve_with_cosine(sky);
    for (const glm::vec3 n : directions(50)) {
        const double t = std::acos(static_cast<double>(n.z));
        const double wanted = 2.0 / 3 * (std::sin(t) + (pi - t) * std::cos(t));
        EXPECT_NEAR(evaluate_sh(sky, glm::normalize(glm::dvec3(n))), wanted, missing + 1e-9) << "t " << t;
    }
}

TEST(ShIrradiance, IsTheConvolvedRadiance) {
    std::mt19937_64 random(4);
    for (const int bands : {1, 2, 3, 4, 5, 12, max_sh_bands}) {
        const std::vector<glm::vec3> radiance = grey(random_numbers(sh_size(bands), random));
        std::vector<glm::vec3> convolved = radiance;
        convolve_with_cosine(convolved);
        for (const glm::vec3 n : directions(20)) {
            EXPECT_NEAR(irradiance_from_sh(radiance, n).b, evaluate_sh(convolved, n).b, 1e-5) << bands << " bands";
        }
    }
}

// Of 3 bands, E(c) = 1/4 + c/2 + 5/32 (3 c^2 - 1) at cosine c: at most 1.0625, at least -19/480 where c = -8/15.
TEST(ShIrradiance, OneDistantLightStaysInStatedRange) {
    const glm::dvec3 light = glm::normalize(glm::dvec3(1, 2, -2));
    const glm::dvec3 side = glm::normalize(glm::cross(light, glm::dvec3(0, 1, 0)));
    const glm::vec3 lux(2, 100'000, 1e-4);
    const std::vector<glm::vec3> radiance = delta_light_sh(3, light, lux);
    const auto irradiance = [&](double degrees) {
        const double t = degrees * pi / 180;
        return irradiance_from_sh(radiance, std::cos(t) * light + std::sin(t) * side) / lux;
    };
    double lowest = 0;
    double lowest_at = 0;
    for (double degrees = 0; degrees <= 180; degrees += 0.05) {
        const glm::dvec3 e = irradiance(degrees);
        const double c = std::cos(degrees * pi / 180);
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(e[k], 0.25 + 0.5 * c + 5.0 / 32 * (3 * c * c - 1), 2e-6) << degrees;
        if (e.r < lowest) {
            lowest = e.r;
            lowest_at = degrees;
        }
    }
    EXPECT_NEAR(irradiance(0).g, 1.0625, 1e-6);
    EXPECT_NEAR(lowest, -0.0396, 2e-5);
    EXPECT_NEAR(lowest_at, 122.2, 0.2);
}

// ------------------------------------------------------------------------------------------------------- Rotation

TEST(ShRotation, AgreesWithProjectingTheTurnedFunction) {
    std::mt19937_64 random(5);
    for (const int bands : {1, 2, 3, 5, 12, max_sh_bands}) {
        const glm::dmat3 turn = random_rotation(random);
        std::vector<double> c = random_numbers(sh_size(bands), random);
        const auto turned = [&](glm::dvec3 d) { return evaluate_sh(c, glm::transpose(turn) * d); };
        const std::vector<double> wanted = project_exactly(bands, turned);
        ShRotation(bands, turn).apply(c);
        EXPECT_LT(largest_difference(c, wanted), 1e-11) << bands << " bands";
    }
}

TEST(ShRotation, TurnsALightWithTheLevel) {
    std::mt19937_64 random(6);
    const glm::dmat3 turn = random_rotation(random);
    const glm::dvec3 light = random_direction(random);
    std::vector<glm::vec3> c = delta_light_sh(9, light, glm::vec3(1, 2, 3));
    const std::vector<glm::vec3> wanted = delta_light_sh(9, turn * light, glm::vec3(1, 2, 3));
    ShRotation(9, turn).apply(c);
    for (int i = 0; i < 81; ++i) {
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(c[i][k], wanted[i][k], 20 * float_ulp);
    }
}

TEST(ShRotation, RotatingBothChangesNothing) {
    std::mt19937_64 random(8);
    const glm::dmat3 turn = random_rotation(random);
    const std::vector<glm::vec3> radiance = grey(random_numbers(9, random));
    std::vector<glm::vec3> turned = radiance;
    ShRotation(3, turn).apply(turned);
    for (const glm::vec3 n : directions(50)) {
        EXPECT_NEAR(irradiance_from_sh(turned, turn * glm::dvec3(n)).r, irradiance_from_sh(radiance, n).r, 1e-5);
    }
}

TEST(ShRotation, KeepsTheNormOfEveryBand) {
    std::mt19937_64 random(9);
    const std::vector<double> c = random_numbers(sh_size(max_sh_bands), random);
    std::vector<double> turned = c;
    ShRotation(max_sh_bands, random_rotation(random)).apply(turned);
    for (int l = 0; l < max_sh_bands; ++l) {
        EXPECT_NEAR(norm2_of_band(turned, l) / norm2_of_band(c, l), 1, 1e-12) << "l " << l;
    }
}

TEST(ShRotation, Composes) {
    std::mt19937_64 random(10);
    const glm::dmat3 first = random_rotation(random);
    const glm::dmat3 second = random_rotation(random);
    std::vector<double> one_by_one = random_numbers(sh_size(max_sh_bands), random);
    std::vector<double> at_once = one_by_one;
    ShRotation(max_sh_bands, first).apply(one_by_one);
    ShRotation(max_sh_bands, second).apply(one_by_one);
    ShRotation(max_sh_bands, second * first).apply(at_once);
    EXPECT_LT(largest_difference(one_by_one, at_once), 1e-11);
}

TEST(ShRotation, StaysOrthogonalWhenChainedAThousandTimes) {
    std::mt19937_64 random(11);
    const glm::dmat3 turn = random_rotation(random);
    const ShRotation rotation(max_sh_bands, turn);
    const ShRotation back(max_sh_bands, glm::transpose(turn));
    const std::vector<double> c = random_numbers(sh_size(max_sh_bands), random);
    std::vector<double> turned = c;
    for (int i = 0; i < 1000; ++i) rotation.apply(turned);
    EXPECT_GT(largest_difference(turned, c), 1);
    for (int i = 0; i < 1000; ++i) back.apply(turned);
    EXPECT_LT(largest_difference(turned, c), 1e-9);
}

TEST(ShRotation, OfNothingChangesNothing) {
    std::mt19937_64 random(12);
    const std::vector<double> c = random_numbers(sh_size(max_sh_bands), random);
    std::vector<double> turned = c;
    ShRotation(max_sh_bands, glm::dmat3(1)).apply(turned);
    EXPECT_LT(largest_difference(turned, c), 1e-12);
}

TEST(ShRotation, TakesReflectionsToo) {
    std::mt19937_64 random(13);
    const glm::dmat3 mirror(glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, -1));
    const glm::dmat3 turn = mirror * random_rotation(random);
    const glm::dvec3 d = random_direction(random);
    std::vector<double> c = basis_at(8, d);
    ShRotation(8, turn).apply(c);
    EXPECT_LT(largest_difference(c, basis_at(8, turn * d)), 1e-13);
}

TEST(ShRotation, MakesARoundedMatrixOrthonormal) {
    std::mt19937_64 random(14);
    const glm::dmat3 rounded = glm::dmat3(glm::mat3(random_rotation(random)));
    std::vector<double> c = random_numbers(sh_size(max_sh_bands), random);
    const double norm = std::inner_product(c.begin(), c.end(), c.begin(), 0.0);
    ShRotation(max_sh_bands, rounded).apply(c);
    EXPECT_NEAR(std::inner_product(c.begin(), c.end(), c.begin(), 0.0) / norm, 1, 1e-12);
}

TEST(ShRotation, TurnsFewerBandsThanItHas) {
    std::mt19937_64 random(15);
    const glm::dmat3 turn = random_rotation(random);
    const std::vector<double> c = random_numbers(9, random);
    std::vector<double> by_three = c;
    std::vector<double> by_seven = c;
    ShRotation(3, turn).apply(by_three);
    ShRotation(7, turn).apply(by_seven);
    EXPECT_EQ(by_three, by_seven);
}

// ------------------------------------------------------------------------------------------------------ Deringing

constexpr std::array windows{ShWindow::hann, ShWindow::lanczos, ShWindow::laplacian, ShWindow::poisson};

TEST(ShWindow, HasTheStatedFactors) {
    EXPECT_NEAR(window_factor(ShWindow::hann, 1, 0.5), 0.5, double_ulp);
    EXPECT_NEAR(window_factor(ShWindow::lanczos, 1, 0.5), 2 / pi, double_ulp);
    EXPECT_NEAR(window_factor(ShWindow::laplacian, 2, 1), 1.0 / 37, double_ulp);
    EXPECT_NEAR(window_factor(ShWindow::poisson, 3, 0.5), std::exp(-1.5), double_ulp);
    EXPECT_EQ(window_factor(ShWindow::hann, 2, 0.5), 0);
    EXPECT_EQ(window_factor(ShWindow::lanczos, 5, 0.5), 0);
}

TEST(ShWindow, FallsWithBandAndStrengthFromOne) {
    for (const ShWindow window : windows) {
        for (double s = 0; s < 1; s += 0.1) EXPECT_EQ(window_factor(window, 0, s), 1);
        for (int l = 0; l < 10; ++l) {
            EXPECT_EQ(window_factor(window, l, 0), 1);
            for (double s = 0.01; s < 1; s += 0.01) {
                const double factor = window_factor(window, l, s);
                EXPECT_GE(factor, 0);
                EXPECT_LE(factor, window_factor(window, l, s - 0.01));
                EXPECT_GE(factor, window_factor(window, l + 1, s));
            }
        }
    }
}

TEST(ShWindow, ScalesBandByBand) {
    std::vector<double> c(16, 1.0);
    window_sh(c, ShWindow::laplacian, 1);
    for (int l = 0; l < 4; ++l) {
        for (int i = sh_size(l); i < sh_size(l + 1); ++i) EXPECT_EQ(c[i], window_factor(ShWindow::laplacian, l, 1));
    }
}

double lowest_irradiance(const std::vector<glm::vec3>& radiance) {
    static const std::vector<glm::vec3> normals = directions(20'000);
    double lowest = HUGE_VAL;
    for (const glm::vec3 n : normals) {
        const glm::vec3 e = irradiance_from_sh(radiance, n);
        lowest = std::min<double>(lowest, std::min({e.r, e.g, e.b}));
    }
    return lowest;
}

/// Checks that deringing helps, and that one per cent less strength would not.
void expect_least_deringing(const std::vector<glm::vec3>& radiance, ShWindow window) {
    ASSERT_LT(lowest_irradiance(radiance), 0);
    std::vector<glm::vec3> deringed = radiance;
    const double strength = dering_sh(deringed, window);
    EXPECT_GT(strength, 0);
    EXPECT_GE(lowest_irradiance(deringed), 0);
    std::vector<glm::vec3> weaker = radiance;
    window_sh(weaker, window, 0.99 * strength);
    EXPECT_LT(lowest_irradiance(weaker), 0);
}

TEST(ShDeringing, OneDistantLightIsNowhereNegative) {
    std::mt19937_64 random(16);
    for (const ShWindow window : windows) {
        for (const int bands : {3, 4, 5, 7, 11}) {
            SCOPED_TRACE(testing::Message() << bands << " bands, window " << static_cast<int>(window));
            expect_least_deringing(delta_light_sh(bands, random_direction(random), glm::vec3(1, 1e5, 1e-5)), window);
        }
    }
}

TEST(ShDeringing, ManyDistantLightsAreNowhereNegative) {
    std::mt19937_64 random(17);
    for (int trial = 0; trial < 30; ++trial) {
        const int bands = 3 + trial % 4;
        std::vector<glm::vec3> radiance(sh_size(bands), glm::vec3(0));
        for (int light = 0; light < 2; ++light) {
            const glm::vec3 lux(1, light, 2 - light);
            const std::vector<glm::vec3> one = delta_light_sh(bands, random_direction(random), lux);
            for (std::size_t i = 0; i < one.size(); ++i) radiance[i] += one[i];
        }
        SCOPED_TRACE(testing::Message() << "trial " << trial);
        expect_least_deringing(radiance, ShWindow::poisson);
    }
}

TEST(ShDeringing, RandomCoefficientsAreNowhereNegative) {
    std::mt19937_64 random(18);
    for (int trial = 0; trial < 30; ++trial) {
        const int bands = 2 + trial % 7;
        std::vector<glm::vec3> radiance;
        for (int i = 0; i < sh_size(bands); ++i) {
            const std::vector<double> rgb = random_numbers(3, random);
            radiance.emplace_back(rgb[0], rgb[1], rgb[2]);
        }
        radiance[0] = glm::abs(radiance[0]) + 0.1F;
        SCOPED_TRACE(testing::Message() << "trial " << trial);
        expect_least_deringing(radiance, windows[trial % 4]);
    }
}

// Windowed by w1, w2, E(c) = 1/4 + w1/2 c + 5/32 w2 (3 c^2 - 1) is lowest at c = -8/15 w1 / w2, or at -1 if that is
// beyond. With w1 = r, w2 = r^2 that makes r^2 = 56/75.
TEST(ShDeringing, FindsTheClosedFormForOneDistantLight) {
    for (const ShWindow window : windows) {
        std::vector<glm::vec3> radiance = delta_light_sh(3, glm::dvec3(0.6, 0, 0.8), glm::vec3(1));
        const double strength = dering_sh(radiance, window);
        const double w1 = window_factor(window, 1, strength);
        const double w2 = window_factor(window, 2, strength);
        const double c = w2 > 8.0 / 15 * w1 ? -8.0 / 15 * w1 / w2 : -1;
        EXPECT_NEAR(0.25 + w1 / 2 * c + 5.0 / 32 * w2 * (3 * c * c - 1), 0.25e-5, 1e-8) << static_cast<int>(window);
        if (window == ShWindow::poisson) {
            EXPECT_NEAR(w1 * w1, 56.0 / 75, 1e-4);
        }
    }
}

TEST(ShDeringing, KeepsMostWithThePoissonWindow) {
    const auto peak = [](ShWindow window) {
        std::vector<glm::vec3> radiance = delta_light_sh(3, glm::dvec3(0, 1, 0), glm::vec3(1));
        dering_sh(radiance, window);
        return irradiance_from_sh(radiance, glm::vec3(0, 1, 0)).g;
    };
    EXPECT_NEAR(peak(ShWindow::poisson), 0.915, 1e-3);
    EXPECT_NEAR(peak(ShWindow::laplacian), 0.59, 1e-2);
    EXPECT_NEAR(peak(ShWindow::lanczos), 0.50, 1e-2);
    EXPECT_NEAR(peak(ShWindow::hann), 0.50, 1e-2);
}

TEST(ShDeringing, DoesNotDependOnTheAxes) {
    std::mt19937_64 random(19);
    std::vector<glm::vec3> radiance = grey(random_numbers(sh_size(5), random));
    radiance[0] = glm::vec3(2);
    std::vector<glm::vec3> upright = radiance;
    const double wanted = dering_sh(upright);
    ASSERT_GT(wanted, 0);
    for (int trial = 0; trial < 20; ++trial) {
        std::vector<glm::vec3> turned = radiance;
        ShRotation(5, random_rotation(random)).apply(turned);
        EXPECT_NEAR(dering_sh(turned), wanted, 1e-5 * wanted);
    }
}

TEST(ShDeringing, LeavesNonNegativeIrradianceToTheBit) {
    std::mt19937_64 random(20);
    std::vector<glm::vec3> ringing = delta_light_sh(6, random_direction(random), glm::vec3(3, 2, 1));
    dering_sh(ringing);
    const std::vector<glm::vec3> black(9, glm::vec3(0));
    std::vector<glm::vec3> faint = grey(random_numbers(sh_size(5), random));
    faint[0] = glm::vec3(20);
    for (const std::vector<glm::vec3>& radiance : {grey(half_sky(3)), black, faint, ringing}) {
        std::vector<glm::vec3> deringed = radiance;
        EXPECT_EQ(dering_sh(deringed), 0);
        EXPECT_EQ(deringed, radiance);
    }
}

TEST(ShDeringing, LeavesWhatIsNotFinite) {
    for (const float bad : {HUGE_VALF, -HUGE_VALF, std::nanf("")}) {
        for (const int i : {0, 1, 8}) {
            std::vector<glm::vec3> radiance = delta_light_sh(3, glm::dvec3(0, 0, 1), glm::vec3(1));
            for (glm::vec3& c : radiance) c.g = 0;
            radiance[i].g = bad;
            const double strength = dering_sh(radiance);
            EXPECT_NEAR(std::exp(-2 * strength), 56.0 / 75, 1e-4) << "what the others need";
            EXPECT_FALSE(std::isfinite(radiance[i].g));
        }
    }
}

TEST(ShDeringing, GivesAllChannelsTheWindowOfTheNeediest) {
    const glm::dvec3 light(0, 0.6, -0.8);
    std::vector<glm::vec3> alone = delta_light_sh(3, light, glm::vec3(1, 0, 0));
    std::vector<glm::vec3> beside = alone;
    for (glm::vec3& c : beside) c.g = c.r;
    beside[0].g += 3;  // a sky makes green positive
    const std::vector<glm::vec3> before = beside;
    const double strength = dering_sh(beside);
    EXPECT_EQ(strength, dering_sh(alone));
    for (int i = 0; i < 9; ++i) {
        const double factor = window_factor(ShWindow::poisson, sh_bands(i + 1) - 1, strength);
        EXPECT_EQ(beside[i].r, alone[i].r);
        EXPECT_NEAR(beside[i].g, before[i].g * factor, float_ulp);
        EXPECT_EQ(beside[i].b, 0);
    }
}

TEST(ShDeringing, BlackensAChannelThatIsNegativeOnAverage) {
    std::vector<glm::vec3> radiance = grey(half_sky(3));
    for (glm::vec3& c : radiance) c.g *= -1;
    const std::vector<glm::vec3> before = radiance;
    EXPECT_EQ(dering_sh(radiance), 0);
    for (int i = 0; i < 9; ++i) EXPECT_EQ(radiance[i], before[i] * glm::vec3(1, 0, 1));
}

}  // namespace
}  // namespace lightgrid
