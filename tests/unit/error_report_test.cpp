#include "probes/error_report.h"

#include "probes/half_storage.h"
#include "probes/look_ups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace lightgrid {
namespace {

/// A volume of noisy probes, and an independent answer at points between them that it does not match.
struct Measured {
    Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {5, 4, 3}}}, 3);
    HeldOut held_out;

    explicit Measured(std::size_t points) {
        std::mt19937 random(1);
        std::normal_distribution<float> normal;
        const auto vector = [&] { return glm::vec3(normal(random), normal(random), normal(random)); };
        for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
            if (volume.states[slot] == ProbeState::absent) continue;
            for (std::size_t i = 0; i < 9; ++i) {
                volume.coefficients[9 * slot + i] = (i == 0 ? glm::vec3(4) : glm::vec3(0)) + 0.2F * vector();
                volume.errors[9 * slot + i] = glm::abs(0.05F * vector());
            }
        }
        std::uniform_real_distribution<double> place(0, 1);
        for (std::size_t i = 0; i < points; ++i) {
            held_out.points.emplace_back(4 * place(random), 3 * place(random), 2 * place(random));
            held_out.weights.push_back(1);
        }
        for (Gather* half : {&held_out.a, &held_out.b}) {
            half->bands = 3;
            half->normals = 64;
            for (std::size_t i = 0; i < points; ++i) {
                for (int k = 0; k < 9; ++k) {
                    half->coefficients.push_back({glm::dvec3(k == 0 ? 4 : 0) + 0.1 * glm::dvec3(vector()), {}});
                }
                for (int k = 0; k < 64; ++k) half->irradiance.push_back({3.5 + 0.3 * glm::dvec3(vector()), {}});
            }
        }
    }
};

double square(const ErrorPart& part) {
    return part.relrmse * std::abs(part.relrmse);
}

TEST(ErrorReport, PartsAndWhatTheyHaveInCommonAddUpToTheTotal) {
    Measured measured(40);
    const Volume exact = measured.volume;
    store_as_half(measured.volume);
    const ErrorReport report = measure_error(measured.volume, measured.held_out, &exact);
    EXPECT_NE(report.cross.relrmse, 0);
    EXPECT_GT(report.storage.relrmse, 0);
    const double sum = square(report.noise) + square(report.bands) + square(report.interpolation) +
                       square(report.storage) + square(report.cross);
    EXPECT_NEAR(sum, square(report.total), 1e-9);
}

TEST(ErrorReport, StorageIsWhatRoundingChanged) {
    Measured measured(40);
    EXPECT_EQ(measure_error(measured.volume, measured.held_out).storage.relrmse, 0);
    const Volume exact = measured.volume;
    for (glm::vec3& value : measured.volume.coefficients) value *= 1.01F;
    const ErrorPart storage = measure_error(measured.volume, measured.held_out, &exact).storage;
    EXPECT_NEAR(storage.relrmse, 0.01, 0.001) << "of the volume's light, which is that of the reference within 5 %";
    EXPECT_LT(storage.interval.low, storage.relrmse);
    EXPECT_GT(storage.interval.high, storage.relrmse);
}

TEST(ErrorReport, NoiseIsThatOfTheCornersThatAnswer) {
    Measured measured(200);
    for (glm::vec3& error : measured.volume.errors) error = glm::vec3(0.1F);
    const ErrorPart all = measure_error(measured.volume, measured.held_out).noise;
    const ErrorPart one =
        measure_error(measured.volume, measured.held_out, nullptr, {.interpolation = Interpolation::nearest}).noise;
    // The mean over a cell of the squares of trilinear weights is (2/3)^3.
    EXPECT_NEAR(all.relrmse / one.relrmse, std::pow(2.0 / 3, 1.5), 0.05);
}

TEST(ErrorReport, TheTotalAloneIsThatOfTheWhole) {
    const Measured measured(40);
    for (const Interpolation interpolation : {Interpolation::trilinear, Interpolation::nearest}) {
        const SampleOptions look_up{.interpolation = interpolation};
        const ErrorPart whole = measure_error(measured.volume, measured.held_out, nullptr, look_up).total;
        const ErrorPart alone = measure_total(measured.volume, measured.held_out, look_up);
        EXPECT_EQ(alone.relrmse, whole.relrmse);
        EXPECT_EQ(alone.interval.low, whole.interval.low);
        EXPECT_EQ(alone.interval.high, whole.interval.high);
    }
}

TEST(ErrorReport, PointsCountAsTheirWeightsSay) {
    Measured once(40);
    Measured twice = once;
    for (std::size_t i = 0; i < 20; ++i) {
        once.held_out.weights[i] = 2;
        twice.held_out.points.push_back(twice.held_out.points[i]);
        twice.held_out.weights.push_back(1);
        for (Gather* half : {&twice.held_out.a, &twice.held_out.b}) {
            for (std::size_t k = 0; k < 9; ++k) half->coefficients.push_back(half->coefficients[9 * i + k]);
            for (std::size_t k = 0; k < 64; ++k) half->irradiance.push_back(half->irradiance[64 * i + k]);
        }
    }
    const ErrorReport weighted = measure_error(once.volume, once.held_out);
    const ErrorReport repeated = measure_error(twice.volume, twice.held_out);
    EXPECT_NEAR(weighted.total.relrmse, repeated.total.relrmse, 1e-9);
    EXPECT_NEAR(weighted.bands.relrmse, repeated.bands.relrmse, 1e-9);
    EXPECT_NEAR(weighted.noise.relrmse, repeated.noise.relrmse, 1e-9);
    EXPECT_EQ(weighted.p50, repeated.p50);
    EXPECT_EQ(weighted.p95, repeated.p95);
    EXPECT_NE(weighted.total.relrmse, measure_error(Measured(40).volume, Measured(40).held_out).total.relrmse);
}

/// Points whose light is off by log-normal shares of it: as many runs, each with points of its own.
TEST(ErrorReport, IntervalsHoldTheTruthAsOftenAsTheySay) {
    constexpr int runs = 200;
    constexpr std::size_t points = 64;
    constexpr double median = 0.1;
    constexpr double sigma = 0.3;
    Measured measured(points);
    std::fill(measured.volume.errors.begin(), measured.volume.errors.end(), glm::vec3(0));
    for (std::size_t i = 0; i < measured.volume.coefficients.size(); ++i) {
        measured.volume.coefficients[i] = glm::vec3(i % 9 == 0 ? 4 : 0);
    }
    const double irradiance = Sampler(measured.volume).irradiance({1.3, 1.3, 1.3}, {0, 1, 0}).x;
    const double mean_off = median * std::exp(0.5 * sigma * sigma);
    const double mean_square_off = median * median * std::exp(2 * sigma * sigma);
    const double truth = std::sqrt(mean_square_off / (1 + 2 * mean_off + mean_square_off));
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    int held = 0;
    for (int run = 0; run < runs; ++run) {
        for (std::size_t i = 0; i < points; ++i) {
            const double off = median * std::exp(sigma * normal(random));
            for (std::size_t k = 0; k < 64; ++k) {
                const glm::dvec3 there(irradiance * (1 + off));
                measured.held_out.a.irradiance[64 * i + k].mean = measured.held_out.b.irradiance[64 * i + k].mean =
                    there;
            }
        }
        const Interval interval = measure_error(measured.volume, measured.held_out).total.interval;
        held += interval.low <= truth && truth <= interval.high ? 1 : 0;
    }
    EXPECT_GE(held, 0.91 * runs);
    EXPECT_LE(held, 0.98 * runs);
}

TEST(LookUps, AreAllBandsFloatAndHalfTrilinearAndNearest) {
    const Measured measured(20);
    const std::vector<LookUpCost> look_ups = compare_look_ups(measured.volume, measured.held_out, 0);
    ASSERT_EQ(look_ups.size(), 12U);
    for (const LookUpCost& look_up : look_ups) {
        EXPECT_EQ(look_up.bytes, static_cast<std::size_t>(3 * look_up.bands * look_up.bands * (look_up.half ? 2 : 4)));
        EXPECT_GT(look_up.nanoseconds, 0);
        EXPECT_GT(look_up.error.relrmse, 0);
        EXPECT_LE(look_up.error.interval.low, look_up.error.interval.high);
    }
    const auto found = [&](Interpolation interpolation, int bands, bool half) {
        return std::find_if(look_ups.begin(), look_ups.end(), [&](const LookUpCost& l) {
            return l.interpolation == interpolation && l.bands == bands && l.half == half;
        });
    };
    const double own = measure_error(measured.volume, measured.held_out).total.relrmse;
    EXPECT_EQ(found(Interpolation::trilinear, 3, false)->error.relrmse, own);
    EXPECT_NEAR(found(Interpolation::trilinear, 3, true)->error.relrmse, own, 1e-3 * own);
    EXPECT_NE(found(Interpolation::nearest, 3, false)->error.relrmse, own);
    EXPECT_NE(found(Interpolation::trilinear, 1, false)->error.relrmse, own);
}

}  // namespace
}  // namespace lightgrid
