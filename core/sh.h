#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

/// Real spherical harmonics, orthonormal over the sphere, without the Condon-Shortley phase, in the level's axes.
/// (l, m) is stored at l * (l + 1) + m; "bands" counts degrees: 3 bands are l = 0, 1, 2, nine coefficients.
namespace lightgrid {

inline constexpr int max_sh_bands = 51;  // l = 0 .. 50, tested for orthonormality

[[nodiscard]] constexpr int sh_size(int bands) { return bands * bands; }

/// Values of all basis functions at `direction`.
///
/// direction  unit length to 1e-4
/// values     bands^2 numbers, written
void sh_basis(int bands, glm::vec3 direction, std::span<float> values) noexcept;
void sh_basis(int bands, glm::dvec3 direction, std::span<double> values) noexcept;

/// A_l, the factor by which convolution with the clamped cosine scales band l: pi, 2pi/3, pi/4, 0, -pi/24, 0, ...
[[nodiscard]] double cosine_lobe(int band) noexcept;

/// Irradiance on a surface element facing `normal` from coefficients of incident radiance (bands^2 of them). May be
/// negative where the truncated series rings. Not clamped.
[[nodiscard]] glm::vec3 irradiance_from_sh(std::span<const glm::vec3> radiance, glm::vec3 normal) noexcept;

}  // namespace lightgrid
