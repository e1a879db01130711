#include "viewer/crowd.h"

#include <cmath>

namespace lightgrid {
namespace {

constexpr double ball_radius = 0.06;  // spacings
constexpr double circle_radius = 0.2;
constexpr double turn_s = 4;
constexpr double golden_angle = 2.399963;  // radians: spreads phases evenly

}  // namespace

std::vector<Ball> crowd_at(const LitVolume& lit, double time_s, glm::dvec3 origin) {
    std::vector<std::size_t> valid;
    for (std::size_t slot = 0; slot < lit.volume.slots(); ++slot) {
        if (is_valid(lit.volume.states[slot])) valid.push_back(slot);
    }
    std::vector<Ball> balls;
    if (valid.empty()) return balls;
    balls.resize(crowd_size);
    for (std::size_t i = 0; i < crowd_size; ++i) {
        const std::size_t slot = valid[i * valid.size() / crowd_size];
        const double angle = golden_angle * static_cast<double>(i) + 2 * std::acos(-1.0) * time_s / turn_s;
        const glm::dvec3 off(std::cos(angle), std::sin(2 * angle) / 2, std::sin(angle));
        balls[i].center = glm::vec3(gather_position(lit.volume, slot) + circle_radius * lit.spacing * off - origin);
        balls[i].radius = static_cast<float>(ball_radius * lit.spacing);
    }
    return balls;
}

void light_crowd(const LookUp& from, glm::dvec3 origin, std::span<Ball> balls) {
    for (Ball& ball : balls) ball.radiance = radiance_sh(from, origin + glm::dvec3(ball.center));
}

}  // namespace lightgrid
