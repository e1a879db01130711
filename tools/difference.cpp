#include "tools/difference.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace lightgrid {
namespace {

double ratio(double numerator, double denominator) {
    if (denominator > 0) return numerator / denominator;
    return numerator == 0 ? 0 : std::numeric_limits<double>::infinity();
}

double quantile(std::vector<float>& values, double share) {
    const auto at = static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(values.size() - 1)));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[at];
}

}  // namespace

DifferenceMeter::Sums& DifferenceMeter::Sums::operator+=(const Sums& other) {
    squared_difference += other.squared_difference;
    squared_reference += other.squared_reference;
    variance += other.variance;
    difference += other.difference;
    reference += other.reference;
    values += other.values;
    return *this;
}

double DifferenceMeter::Sums::relative_rms() const {
    // Noise may leave less than nothing of a small difference.
    return std::sqrt(ratio(std::max(squared_difference - variance, 0.0), squared_reference - variance));
}

void DifferenceMeter::add_point(std::span<const ComparedIrradiance> normals) {
    if (normals.empty()) return;
    Sums& sums = points_.emplace_back();
    for (const ComparedIrradiance& compared : normals) {
        for (int c = 0; c < 3; ++c) {
            const double reference = compared.reference[c];
            const double error = compared.reference_error[c];
            const double difference = static_cast<double>(compared.value[c]) - reference;
            sums += {difference * difference, reference * reference, error * error, difference, reference, 1};
            references_.push_back(compared.reference[c]);
            differences_.push_back(static_cast<float>(std::abs(difference)));
        }
    }
}

std::pair<double, double> DifferenceMeter::resampled_interval() const {
    constexpr std::size_t resamplings = 1000;
    std::mt19937_64 random(1);  // NOLINT: the same interval every time
    std::vector<double> results(resamplings);
    for (double& result : results) {
        Sums sums;
        for (std::size_t i = 0; i < points_.size(); ++i) {
            // 32 random bits times the size, the product's upper half: an index.
            sums += points_[(random() >> 32) * points_.size() >> 32];
        }
        result = sums.relative_rms();
    }
    std::sort(results.begin(), results.end());
    constexpr std::size_t tail = resamplings / 40;  // 2.5 %
    return {results[tail], results[resamplings - 1 - tail]};
}

Difference DifferenceMeter::measure() const {
    Difference result;
    if (points_.empty()) return result;
    Sums total;
    for (const Sums& point : points_) total += point;
    result.points = points_.size();
    result.values = total.values;
    result.relrmse = total.relative_rms();
    if (points_.size() > 1) result.interval = resampled_interval();
    result.reference_noise = std::sqrt(ratio(total.variance, total.squared_reference));
    result.mean_error = total.difference == 0 ? 0 : total.difference / total.reference;

    std::vector<float> scratch = references_;
    const double least = 0.01 * quantile(scratch, 0.5);
    scratch.clear();
    for (const Sums& point : points_) {
        const double scale = std::max(point.reference / static_cast<double>(point.values), least);
        for (std::size_t i = 0; i < point.values; ++i) {
            scratch.push_back(static_cast<float>(ratio(differences_[scratch.size()], scale)));
        }
    }
    result.p50 = quantile(scratch, 0.50);
    result.p95 = quantile(scratch, 0.95);
    result.p99 = quantile(scratch, 0.99);
    return result;
}

}  // namespace lightgrid
