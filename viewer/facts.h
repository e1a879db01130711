#pragma once

#include "tools/volume_summary.h"
#include "viewer/look_up.h"
#include "viewer/reference_probe.h"

#include <glm/glm.hpp>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

/// What the overlay tells of what is shown, as plain data.
namespace lightgrid {

/// Says something to the person who looks: on the terminal, and in the window for a while.
using Tell = std::function<void(const std::string&)>;

/// The path tracer's light where a person clicked, beside the volume's.
struct ClickedLight {
    glm::dvec3 position{0};
    bool on_surface = false;
    std::uint32_t samples = 0;  // rays of the reference so far; 0: none yet
    bool last = false;
    LightComparison irradiance;  // on what faces the eye there
    Sh36 volume{};               // radiance
    Sh36 reference{};
};

struct EnvironmentFacts {
    std::string file;
    bool loading = false;
    double error = 0;  // irradiance_difference() to the reference
};

struct Facts {
    double frame_ms = 0;
    std::size_t look_ups = 0;  // in the last frame
    std::size_t bytes = 0;     // of light: volumes in memory and tables on the card
    std::shared_ptr<const LitVolume> volume;
    VolumeSummary summary;         // of it
    double metres_per_unit = 1;    // of the level's lengths
    std::string baking;            // what a bake does now; empty: none
    std::string object_reference;  // how far the reference at the object is; empty: not wanted
    std::string map;               // how much of the map of differences is known; empty: not wanted
    std::optional<ClickedLight> clicked;
    std::optional<EnvironmentFacts> environment;
};

}  // namespace lightgrid
