#pragma once

#include "core/environment.h"
#include "core/scene.h"

#include <glm/glm.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lightgrid {

/// Which source each part of a level's light belongs to: estimates of light are kept apart by source. What belongs to
/// none is off. Made as it is, all light is one source.
struct LightSources {
    static constexpr std::uint32_t off = 0xffffffffU;
    static constexpr std::uint32_t most = 64;

    std::uint32_t count = 1;
    std::vector<std::uint32_t> of_material;  // its emission, by material; empty: source 0
    std::vector<std::uint32_t> of_light;     // by punctual light; likewise
    std::uint32_t of_sky = 0;

    [[nodiscard]] std::uint32_t material(int index) const noexcept {
        return of_material.empty() ? 0 : of_material[static_cast<std::size_t>(index)];
    }
    [[nodiscard]] std::uint32_t light(std::size_t index) const noexcept {
        return of_light.empty() ? 0 : of_light[index];
    }
};

/// A source for the sky and for each emissive material and punctual light that is not black; if these are more than
/// LightSources::most, the last ones share one.
[[nodiscard]] LightSources separate_sources(const Scene& scene, const Environment& environment);

/// All that shines in a level, to be compared with what shines in it later.
struct LightState {
    LightSources sources;
    std::vector<glm::vec3> emission;  // factor, by material
    std::vector<Light> lights;        // without their names
    std::uint64_t sky_shape = 0;      // Environment::shape, scale
    glm::vec3 sky_scale{0};
};
[[nodiscard]] LightState light_of(const Scene& scene, const Environment& environment, const LightSources& sources);

/// What has become of the light of a level whose materials are the same but for emission.
struct LightChange {
    std::vector<glm::vec3> factor;  // by source, by colour: of what it brought it now brings so much
    LightSources others;            // light that no factor gives: new, moved, or of a colour that was black. Source 0
    bool sky_is_new = false;        // it is one of them
    bool any_other = false;
};

/// A source of several lights has one factor for all; where they differ, all of them are among the others.
[[nodiscard]] LightChange compare_light(const LightState& before, const Scene& scene, const Environment& environment);

}  // namespace lightgrid
