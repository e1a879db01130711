#include "viewer/exposure.h"

#include "core/sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lightgrid {
namespace {

constexpr double shown_grey = 0.16;
constexpr double albedo = 0.5;
/// How far the eye adapts to where it is: 0 not at all, 1 wholly.
constexpr double adaptation = 0.8;
/// Beyond this ratio to the whole volume's light the eye adapts no further.
constexpr double widest = 50;
/// Where light is looked at, in cells before the eye.
constexpr std::array<double, 4> distances{0, 1, 2, 4};

}  // namespace

float automatic_exposure_at(const LookUp& light, const Pose& pose) {
    const double usual = luminance(light.volume->usual_light);
    if (!(usual > 0)) return 1;
    double sum = 0;
    for (const double distance : distances) {
        const glm::dvec3 at = pose.eye + distance * light.volume->spacing * forward(pose);
        const double here = luminance(mean_irradiance_at(light, at));
        sum += std::log(std::clamp(here / usual, 1 / widest, widest));
    }
    const double adapted = usual * std::exp(adaptation * sum / distances.size());
    return static_cast<float>(shown_grey * std::numbers::pi / (albedo * adapted));
}

float exposure_of(const Settings& settings, const LookUp& light, const Pose& pose) {
    const bool measured = settings.automatic_exposure && light.volume != nullptr;
    const float base = measured ? automatic_exposure_at(light, pose) : 1.0F;
    return base * std::exp2(std::clamp(settings.exposure_stops, -most_stops, most_stops));
}

}  // namespace lightgrid
