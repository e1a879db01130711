#pragma once

#include "probes/volume.h"
#include "viewer/look_up.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// How the layers of a volume are mixed while one looks at it.
namespace lightgrid {

inline constexpr float most_layer_weight = 4;

/// Of one layer, or of all layers of a sky.
struct LayerKnob {
    std::string name;
    float weight = 1;  // 0 .. most_layer_weight
    glm::vec3 color{1};

    bool operator==(const LayerKnob&) const = default;
};

/// Whose radiance a sky has: the environment that the level is shown with, 1 cd/m^2 from everywhere, or a file's.
enum class SkyShown : std::uint8_t { given, uniform, file };

struct LayerMix {
    std::vector<LayerKnob> knobs;
    SkyShown sky = SkyShown::given;
    double sky_turned_deg = 0;  // counter-clockwise about +Y seen from above

    bool operator==(const LayerMix&) const = default;
};

/// The knob of a sky's layers has this name.
inline constexpr const char* sky_knob = "sky";
/// Null: there is none.
[[nodiscard]] LayerKnob* find_sky(LayerMix& mix) noexcept;

/// Everything as it was baked: what the combined light is, but for what of a sky is above band 2.
///
/// has_sky  the environment that the level is shown with is not black; else the sky is uniform, and off
[[nodiscard]] LayerMix mix_of(const Volume& volume, bool has_sky);

/// What the light that a surface of this group emits is multiplied by: the knob of its layer, that of `other` where the
/// group has none. 1 where the volume does not keep the light of lamps by groups.
///
/// group  empty: of none
[[nodiscard]] glm::vec3 emission_weight(const LayerMix& mix, std::string_view group) noexcept;

/// A weight for each layer of the volume.
///
/// sky  radiance of the one that is shown, not turned
[[nodiscard]] std::vector<glm::vec3> weights_of(const LayerMix& mix, const Volume& volume, const Sh36& sky);

/// The volume with its layers mixed, and without them. Standard errors are those of the combined light.
[[nodiscard]] Volume mixed_volume(const Volume& volume, std::span<const glm::vec3> weights);

}  // namespace lightgrid
