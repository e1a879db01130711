#pragma once

#include "core/environment.h"
#include "viewer/look_up.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

/// The light of an environment alone, by its SH coefficients: the same wherever an object is.
namespace lightgrid {

/// by_brightness: in proportion to luminance, as bakes sample it. evenly: a spherical Fibonacci set, which finds a small
/// sun only with many.
enum class EnvironmentSampling : std::uint8_t { by_brightness, evenly };

struct EnvironmentChoice {
    int samples = 1000;  // fewest_environment_samples .. most_environment_samples
    EnvironmentSampling sampling = EnvironmentSampling::by_brightness;
    double turned_deg = 0;  // counter-clockwise about +Y seen from above

    bool operator==(const EnvironmentChoice&) const = default;
};

inline constexpr int fewest_environment_samples = 10;
inline constexpr int most_environment_samples = 100'000;

/// Coefficients of the environment's radiance from so many of its directions; deterministic. 0.1 us a sample.
[[nodiscard]] Sh36 sample_environment(const Environment& environment, int samples, EnvironmentSampling sampling);

/// Of what nobody can tell from all directions: its irradiance is exact to 1e-3.
[[nodiscard]] Sh36 reference_environment(const Environment& environment);

/// Error of the irradiance: root mean square over all normals, relative to the reference's.
[[nodiscard]] double irradiance_difference(const Sh36& sh, const Sh36& reference);

/// Counter-clockwise about +Y seen from above: 90 brings what was at +X to -Z.
[[nodiscard]] glm::dmat3 turn_about_up(double deg);
/// Light turned with what it comes from.
[[nodiscard]] Sh36 turned(const Sh36& sh, double deg);

/// A volume with this light everywhere.
[[nodiscard]] std::shared_ptr<const LitVolume> volume_of(const Sh36& sh);

/// The .hdr or .exr file behind this one in its folder, by name; the first comes behind the last. None: there is no
/// other.
[[nodiscard]] std::optional<std::filesystem::path> next_environment(const std::filesystem::path& file);

}  // namespace lightgrid
