#pragma once

#include "probes/volume.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>

/// Coefficients as half: 11 significant bits, scaled per brick so that they neither overflow nor flush to zero.
namespace lightgrid {

/// The power of two that a brick's numbers are divided by before they become half: the largest of them lands in
/// [2^14, 2^15], so that what is 2^-29 times as large is still normal. Exact, and the same for numbers that were
/// rounded so before. 1 for a brick that is zero. `more`: numbers that share the scale (axis errors with errors).
[[nodiscard]] float half_scale(std::span<const glm::vec3> brick, std::span<const glm::vec3> more = {}) noexcept;

/// `value` / `scale` as the bits of the nearest half (ties to even), and back. Within the brick of `scale`:
///   |from_half(to_half(v, s), s) - v| <= max(2^-11 |v|, 2^-25 s)
[[nodiscard]] std::uint16_t to_half(float value, float scale) noexcept;
[[nodiscard]] float from_half(std::uint16_t bits, float scale) noexcept;

struct StorageChoice {
    bool half = false;          // serves: the larger error below is at most max_storage_share
    double worst_share = 0;     // of all bricks: storage error / standard error; infinite where only the latter is zero
    double irradiance_rms = 0;  // lux: what half storage would change, over the valid probes, normals and RGB
};

/// A tenth in standard error is half a percent in the total: 1.005 = sqrt(1 + 0.1^2).
inline constexpr double max_storage_share = 0.1;

/// Whether half serves: in every brick, rounding costs at most a tenth of the standard error that the brick has anyway.
/// Both are root mean squares of irradiance over all normals, the brick's probes (64 rows of a list) and RGB:
///   mean over n of E(n)^2 = sum_l A_l^2 sum_m L_lm^2 / (4 pi),
/// exact for the noise too, because the basis is orthogonal (core/sh.h holds A and its source). Light without noise
/// stays float.
[[nodiscard]] StorageChoice choose_storage(const Volume& volume);

/// Rounds the volume to what half storage holds, marks it `half`, and adds (in quadrature) what that changed to the
/// standard errors of coefficients and axes. Layers are rounded with scales of their own. Saving and loading changes no number after that.
void store_as_half(Volume& volume);

}  // namespace lightgrid
