#pragma once

#include <glm/glm.hpp>

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace lightgrid {

/// Irradiance for one normal: the reference's and what is compared with it, lux.
struct ComparedIrradiance {
    glm::vec3 reference{0};
    glm::vec3 reference_error{0};  // standard error; 0: exact or unknown
    glm::vec3 value{0};
};

/// How far values are from their reference. Points are the sampling unit.
struct Difference {
    std::size_t points = 0;
    std::size_t values = 0;  // points * normals * 3
    /// sqrt(sum (value - reference)^2 / sum reference^2), the reference's own variance subtracted from both sums;
    /// infinite where the reference is dark and the value is not
    double relrmse = 0;
    /// 95 % of resamplings of the points (bootstrap, percentiles); nothing for a single point
    std::optional<std::pair<double, double>> interval;
    double reference_noise = 0;  // sqrt(sum reference_error^2 / sum reference^2)
    double mean_error = 0;       // sum (value - reference) / sum reference
    /// quantiles of |value - reference| / max(mean reference at the point, 1 % of the median reference of all)
    double p50 = 0;
    double p95 = 0;
    double p99 = 0;
};

/// Collects points and measures at the end. Deterministic: the resampling has its own fixed seed.
class DifferenceMeter {
  public:
    /// All normals of one point.
    void add_point(std::span<const ComparedIrradiance> normals);
    /// All zero if there was no point.
    [[nodiscard]] Difference measure() const;

  private:
    // Sums over the values of a point or of all.
    struct Sums {
        double squared_difference = 0;
        double squared_reference = 0;
        double variance = 0;
        double difference = 0;
        double reference = 0;
        std::size_t values = 0;

        Sums& operator+=(const Sums& other);
        [[nodiscard]] double relative_rms() const;
    };
    [[nodiscard]] std::pair<double, double> resampled_interval() const;

    std::vector<Sums> points_;
    std::vector<float> references_;   // of all values
    std::vector<float> differences_;  // absolute
};

}  // namespace lightgrid
