#include "probes/linear_solver.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lightgrid {
namespace {

using Vector = std::vector<glm::dvec3>;

/// Rows of positive random numbers that sum to `albedo`, each colour by itself.
struct RandomTransport {
    std::size_t size;
    glm::dvec3 albedo;
    std::vector<glm::dvec3> rows;

    RandomTransport(std::size_t n, glm::dvec3 a, std::uint64_t seed) : size(n), albedo(a), rows(n * n) {
        RandomStream random(seed);
        for (std::size_t i = 0; i < n; ++i) {
            glm::dvec3 sum(0);
            for (std::size_t k = 0; k < n; ++k) {
                const glm::dvec3 value(random.next_double(), random.next_double(), random.next_double());
                sum += rows[i * n + k] = value;
            }
            for (std::size_t k = 0; k < n; ++k) rows[i * n + k] *= albedo / sum;
        }
    }
    void operator()(std::span<const glm::dvec3> x, std::span<glm::dvec3> y) const {
        for (std::size_t i = 0; i < size; ++i) {
            y[i] = x[i];
            for (std::size_t k = 0; k < size; ++k) y[i] -= rows[i * size + k] * x[k];
        }
    }
};

double largest_difference(const Vector& a, const Vector& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(a[i][c] - b[i][c]));
    }
    return largest;
}

Vector random_vector(std::size_t size, std::uint64_t seed) {
    RandomStream random(seed);
    Vector x(size);
    for (glm::dvec3& value : x) value = {random.next_double(), random.next_double(), random.next_double()};
    return x;
}

TEST(LinearSolver, FindsWhatTheRightHandSideWasMadeFrom) {
    const RandomTransport a(100, {0.5, 0.9, 0.99}, 1);
    const Vector x = random_vector(100, 2);
    Vector b(100);
    a(x, b);
    const Solution solution = solve_linear(a, b, 1e-12, 200);
    EXPECT_LE(solution.residual, 1e-12);
    // |b| is below 10 and the inverse of 1 - T at most 1 / (1 - albedo).
    EXPECT_LE(largest_difference(solution.x, x), 10 * 1e-12 / (1 - 0.99));
}

TEST(LinearSolver, StatesTheResidualThatItLeft) {
    const RandomTransport a(60, glm::dvec3(0.95), 3);
    const Vector b = random_vector(60, 4);
    for (const double tolerance : {1e-2, 1e-5, 1e-9}) {
        const Solution solution = solve_linear(a, b, tolerance, 100);
        Vector left(60);
        a(solution.x, left);
        glm::dvec3 squares(0);
        glm::dvec3 scale(0);
        for (std::size_t i = 0; i < left.size(); ++i) {
            squares += (b[i] - left[i]) * (b[i] - left[i]);
            scale += b[i] * b[i];
        }
        const glm::dvec3 relative = glm::sqrt(squares / scale);
        EXPECT_NEAR(solution.residual, std::max({relative.x, relative.y, relative.z}), 1e-14);
        EXPECT_LE(solution.residual, tolerance);
    }
}

TEST(LinearSolver, AChainOfRoomsTakesSweepsAsTheRootOfItsCondition) {
    // Light goes from each place to its two neighbours only: eigenvalues fill [-albedo, albedo], the worst there is.
    const auto sweeps = [](double albedo) {
        const auto chain = [&](std::span<const glm::dvec3> x, std::span<glm::dvec3> y) {
            for (std::size_t i = 0; i < x.size(); ++i) {
                const std::size_t left = i == 0 ? x.size() - 1 : i - 1;
                const std::size_t right = i + 1 == x.size() ? 0 : i + 1;
                y[i] = x[i] - 0.5 * albedo * (x[left] + x[right]);
            }
        };
        Vector b(4000, glm::dvec3(0));
        b[0] = {1, 0.5, 0.25};
        const Solution solution = solve_linear(chain, b, 1e-6, 5000);
        EXPECT_LE(solution.residual, 1e-6) << albedo;
        return solution.sweeps;
    };
    const int at_90 = sweeps(0.9);
    const int at_99 = sweeps(0.99);
    RecordProperty("sweeps_90", at_90);
    RecordProperty("sweeps_99", at_99);
    EXPECT_LE(at_99, 1.5 * std::sqrt(10) * at_90) << "and not ten times as many";
}

TEST(LinearSolver, ABlackColourOrNoLightAtAllIsSolvedAtOnce) {
    const RandomTransport a(20, {0, 0.5, 0.9}, 5);
    Vector b = random_vector(20, 6);
    for (glm::dvec3& value : b) value.z = 0;
    const Solution solution = solve_linear(a, b, 1e-10, 100);
    for (std::size_t i = 0; i < b.size(); ++i) {
        EXPECT_NEAR(solution.x[i].x, b[i].x, 1e-9);
        EXPECT_EQ(solution.x[i].z, 0);
    }
    const Solution dark = solve_linear(a, Vector(20, glm::dvec3(0)), 1e-10, 100);
    EXPECT_EQ(dark.sweeps, 0);
    EXPECT_EQ(largest_difference(dark.x, Vector(20, glm::dvec3(0))), 0);
}

TEST(LinearSolver, EndsAtTheMostSweepsAndSaysHowFarItCame) {
    const RandomTransport a(50, glm::dvec3(0.999), 7);
    const Vector b = random_vector(50, 8);
    const Solution solution = solve_linear(a, b, 1e-15, 3);
    EXPECT_LE(solution.sweeps, 4);
    EXPECT_GT(solution.residual, 1e-15);
    EXPECT_LT(solution.residual, 1);
}

TEST(LinearSolver, AnyNumberOfThreadsGivesTheSameBits) {
    const std::size_t size = 20000;
    const auto shift = [](std::span<const glm::dvec3> x, std::span<glm::dvec3> y) {
        for (std::size_t i = 0; i < x.size(); ++i) y[i] = x[i] - 0.9 * x[(i * 7 + 1) % x.size()];
    };
    const Vector b = random_vector(size, 9);
    const auto run = [&](int threads) {
        const ThreadLimit limit(threads);
        return solve_linear(shift, b, 1e-6, 60);
    };
    const Solution one = run(1);
    for (const int threads : {2, 4}) {
        const Solution more = run(threads);
        EXPECT_EQ(one.sweeps, more.sweeps);
        EXPECT_TRUE(one.x == more.x) << threads;
    }
}

}  // namespace
}  // namespace lightgrid
