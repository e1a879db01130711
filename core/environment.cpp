#include "core/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lightgrid {

Environment Environment::uniform(glm::vec3 radiance) {
    Environment environment;
    environment.uniform_ = radiance;
    return environment;
}

bool Environment::is_black() const noexcept {
    return uniform_ == glm::vec3(0);
}

bool Environment::is_uniform() const noexcept {
    return true;
}

glm::vec3 Environment::radiance(glm::vec3) const noexcept {
    return uniform_;
}

Environment::Sample Environment::sample(glm::vec3 u) const noexcept {
    if (is_black()) return {};
    const float y = 1 - 2 * u.x;
    const float r = std::sqrt(std::max(0.0F, 1 - y * y));
    const float phi = 2 * std::numbers::pi_v<float> * u.y;
    return {{r * std::cos(phi), y, r * std::sin(phi)}, uniform_, std::numbers::inv_pi_v<float> / 4};
}

float Environment::pdf(glm::vec3) const noexcept {
    return is_black() ? 0 : std::numbers::inv_pi_v<float> / 4;
}

}  // namespace lightgrid
