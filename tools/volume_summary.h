#pragma once

#include "probes/volume.h"

#include <glm/glm.hpp>

#include <array>
#include <cstddef>

namespace lightgrid {

/// What a volume amounts to.
struct VolumeSummary {
    std::array<std::size_t, 5> states{};  // how many probes, by ProbeState
    glm::dvec3 irradiance{0};             // lux, mean over the valid probes and six axes
    double noise = 0;                     // standard error of irradiance, root mean square over the same and RGB, lux
    double relative_noise = 0;            // that over the root mean square of irradiance
    double worst_noise = 0;               // of the valid probes, each over its own irradiance
    glm::dvec3 worst_position{0};

    [[nodiscard]] std::size_t count(ProbeState state) const { return states[static_cast<std::size_t>(state)]; }
    [[nodiscard]] std::size_t valid() const { return count(ProbeState::valid) + count(ProbeState::moved); }
    [[nodiscard]] std::size_t probes() const {
        return valid() + count(ProbeState::filled) + count(ProbeState::missing);
    }
};
[[nodiscard]] VolumeSummary summarize(const Volume& volume);

}  // namespace lightgrid
