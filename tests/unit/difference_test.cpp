#include "tools/difference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lightgrid {
namespace {

constexpr int normals = 16;

// Points of light 1 that are off by a normally distributed share; the reference has its own noise.
Difference measured(int points, float error, float reference_noise, bool states_noise) {
    std::mt19937 random(1);
    std::normal_distribution<float> normal(0, 1);
    DifferenceMeter meter;
    for (int p = 0; p < points; ++p) {
        std::vector<ComparedIrradiance> compared(normals);
        for (ComparedIrradiance& c : compared) {
            for (int i = 0; i < 3; ++i) {
                c.reference[i] = 1 + reference_noise * normal(random);
                c.value[i] = 1 + error * normal(random);
            }
            if (states_noise) c.reference_error = glm::vec3(reference_noise);
        }
        meter.add_point(compared);
    }
    return meter.measure();
}

TEST(Difference, IsZeroForEqualLight) {
    DifferenceMeter meter;
    const std::vector<ComparedIrradiance> same(6, {glm::vec3(2), glm::vec3(0), glm::vec3(2)});
    meter.add_point(same);
    meter.add_point(same);
    const Difference d = meter.measure();
    EXPECT_EQ(d.relrmse, 0);
    EXPECT_EQ(d.p99, 0);
    EXPECT_EQ(d.points, 2U);
    EXPECT_EQ(d.values, 36U);
    EXPECT_EQ(d.interval->second, 0);
}

TEST(Difference, IsTheShareThatLightIsOff) {
    DifferenceMeter meter;
    for (const float light : {1.0F, 4.0F}) {
        meter.add_point(std::vector<ComparedIrradiance>(6, {glm::vec3(light), glm::vec3(0), glm::vec3(1.1F * light)}));
    }
    const Difference d = meter.measure();
    EXPECT_NEAR(d.relrmse, 0.1, 1e-6);
    EXPECT_NEAR(d.mean_error, 0.1, 1e-6);
    EXPECT_NEAR(d.p50, 0.1, 1e-6);
}

TEST(Difference, TakesTheReferencesOwnNoiseOut) {
    // 100 * 16 * 3 values: the mean square is known to 2 / sqrt(4800) of the larger variance.
    const double tolerance = 4 * std::sqrt(2.0 / 4800) * 0.05 * 0.05;
    EXPECT_NEAR(std::pow(measured(100, 0.02F, 0.05F, true).relrmse, 2), 0.0004, tolerance);
    EXPECT_NEAR(std::pow(measured(100, 0.02F, 0.05F, false).relrmse, 2), 0.0004 + 0.0025, tolerance);
    EXPECT_NEAR(measured(100, 0.02F, 0.05F, true).reference_noise, 0.05, 0.001);
}

TEST(Difference, HasAnIntervalThatHoldsTheTruthAndShrinksWithPoints) {
    const Difference few = measured(20, 0.05F, 0, false);
    const Difference many = measured(2000, 0.05F, 0, false);
    for (const Difference& d : {few, many}) {
        EXPECT_LT(d.interval->first, d.relrmse);
        EXPECT_GT(d.interval->second, d.relrmse);
    }
    const double ratio = (few.interval->second - few.interval->first) / (many.interval->second - many.interval->first);
    EXPECT_GT(ratio, 5);  // sqrt(100) = 10 expected
    EXPECT_LT(ratio, 20);
    EXPECT_FALSE(measured(1, 0.05F, 0, false).interval);
}

TEST(Difference, WeighsDarkPointsAgainstTheLevelsMedian) {
    DifferenceMeter meter;
    for (int i = 0; i < 90; ++i) {
        meter.add_point(std::vector<ComparedIrradiance>(6, {glm::vec3(100), glm::vec3(0), glm::vec3(100)}));
    }
    for (int i = 0; i < 10; ++i) {
        meter.add_point(std::vector<ComparedIrradiance>(6, {glm::vec3(0), glm::vec3(0), glm::vec3(0.5F)}));
    }
    const Difference d = meter.measure();
    EXPECT_EQ(d.p50, 0);
    EXPECT_NEAR(d.p95, 0.5, 1e-6);  // 0.5 lux over 1 % of 100
}

TEST(Difference, IsInfiniteAgainstDarkness) {
    DifferenceMeter meter;
    meter.add_point(std::vector<ComparedIrradiance>(6, {glm::vec3(0), glm::vec3(0), glm::vec3(1)}));
    EXPECT_TRUE(std::isinf(meter.measure().relrmse));
    EXPECT_EQ(DifferenceMeter().measure().relrmse, 0);
}

}  // namespace
}  // namespace lightgrid
