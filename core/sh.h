#pragma once

#include <glm/glm.hpp>

#include <functional>
#include <span>
#include <vector>

/// Real spherical harmonics, orthonormal over the sphere, without the Condon-Shortley phase, in the level's axes:
/// Y_00 = 0.282095, and Y_1-1, Y_10, Y_11 = 0.488603 times y, z, x.
///
/// "Bands" counts degrees: 3 bands are l = 0, 1, 2. The coefficient (l, m), -l <= m <= l, is stored at l (l + 1) + m,
/// and bands^2 of them stand for one function; wherever a function takes coefficients, their number says how many bands
/// there are. Coefficients of light are L_i = integral L(w) Y_i(w) dw of incident radiance L, in cd/m^2 sr^(1/2).
///
/// A number of coefficients that is no square, a band count outside 1 .. max_sh_bands and a direction that is not of
/// unit length are the caller's fault and assert. Non-finite in, non-finite out. Nothing here keeps state; any number
/// of threads may call.
namespace lightgrid {

inline constexpr int max_sh_bands = 51;  // l = 0 .. 50, tested for orthonormality

[[nodiscard]] constexpr int sh_size(int bands) {
    return bands * bands;
}

/// Where coefficient (l, m) is stored.
[[nodiscard]] constexpr int sh_index(int l, int m) {
    return l * (l + 1) + m;
}

/// The inverse of sh_size; rounds up what is no square.
[[nodiscard]] constexpr int sh_bands(std::size_t size) {
    int bands = 0;
    while (static_cast<std::size_t>(sh_size(bands)) < size) ++bands;
    return bands;
}

/// Values of all basis functions at `direction`, by a recurrence that is normalised at every step: no factorials, no
/// special case at the poles.
///
/// direction  unit length to 1e-4. It is not normalised again: a length of 1 + e scales band l by (1 + e)^l, no worse.
/// values     bands^2 numbers, written
/// Cost:      O(bands^2), no allocation; up to 5 bands unrolled and free of branches (4 ns for 3 bands).
void sh_basis(int bands, glm::vec3 direction, std::span<float> values) noexcept;
void sh_basis(int bands, glm::dvec3 direction, std::span<double> values) noexcept;

/// The function that the coefficients stand for, at `direction`.
[[nodiscard]] glm::vec3 evaluate_sh(std::span<const glm::vec3> coefficients, glm::vec3 direction) noexcept;
[[nodiscard]] double evaluate_sh(std::span<const double> coefficients, glm::dvec3 direction) noexcept;

/// Coefficients of any function on the sphere, from its values at the points of a spherical Fibonacci set:
/// deterministic, summed in double. The error falls as samples^-1.5 for a smooth function and about as samples^-0.75
/// for one with edges; for a function of size 1 it is near 1e-5 and 1e-3 with the default.
///
/// function  called once for each of `samples` unit directions
[[nodiscard]] std::vector<glm::vec3> project_to_sh(int bands, const std::function<glm::vec3(glm::dvec3)>& function,
                                                   int samples = 16384);
[[nodiscard]] std::vector<double> project_to_sh(int bands, const std::function<double(glm::dvec3)>& function,
                                                int samples = 16384);

/// Radiance coefficients of a light from one direction only.
///
/// towards_light  unit length, away from the lit point
/// illuminance    lux, on a surface that faces the light
[[nodiscard]] std::vector<glm::vec3> delta_light_sh(int bands, glm::dvec3 towards_light, glm::vec3 illuminance);

/// A_l, the factor by which convolution with the clamped cosine scales band l: pi, 2pi/3, pi/4, 0, -pi/24, 0, ...
/// Source: Ramamoorthi, Hanrahan, "An Efficient Representation for Irradiance Environment Maps", 2001; here as
/// A_l = -A_(l-2) (l - 3) / (l + 2), which needs no factorials.
///
/// band  l >= 0, any
[[nodiscard]] double cosine_lobe(int band) noexcept;

/// Turns coefficients of incident radiance into coefficients of irradiance: band l times A_l.
void convolve_with_cosine(std::span<glm::vec3> coefficients) noexcept;
void convolve_with_cosine(std::span<double> coefficients) noexcept;

/// Irradiance on a surface element facing `normal`, from coefficients of incident radiance:
/// E(n) = sum_l A_l sum_m L_lm Y_lm(n).
///
/// normal   unit length to 1e-4, away from the surface
/// returns  lux. Negative where the truncated series rings: one distant light of 1 lx gives -0.0396 to 1.0625 lx with
///          3 bands. Not clamped: clamp once, after interpolation, or see dering_sh.
[[nodiscard]] glm::vec3 irradiance_from_sh(std::span<const glm::vec3> radiance, glm::vec3 normal) noexcept;

/// How SH turn with the level: coefficients of f become coefficients of f(inverse(R) w), so a light from d becomes a
/// light from R d. Built in double by recurrence from band to band; orthogonal to rounding up to band 50.
///
/// Source: Ivanic, Ruedenberg, "Rotation Matrices for Real Spherical Harmonics. Direct Determination by Recursion",
///         J. Phys. Chem. 1996, with the corrections of 1998.
class ShRotation {
  public:
    /// rotation  orthonormal to 1e-3 (what is missing to exactly orthonormal is put right); a reflection will do, too.
    /// Cost:     O(bands^3) time and memory: 0.1 us for 3 bands; 1 ms and 1.4 MB for 51.
    ShRotation(int bands, const glm::dmat3& rotation);

    [[nodiscard]] int bands() const noexcept { return bands_; }

    /// Turns coefficients in place; at most bands()^2 of them. O(bands^3), no allocation.
    void apply(std::span<glm::vec3> coefficients) const noexcept;
    void apply(std::span<double> coefficients) const noexcept;

  private:
    int bands_;
    std::vector<double> blocks_;  // band after band, (2l + 1)^2 numbers, row by row
};

/// Factors that fade the higher bands out, so that a truncated series rings less and blurs more.
enum class ShWindow {
    hann,       // (1 + cos(pi l s)) / 2, 0 where l s > 1
    lanczos,    // sin(pi l s) / (pi l s), 0 where l s > 1
    laplacian,  // 1 / (1 + s l^2 (l + 1)^2): the best fit under a penalty s on the squared Laplacian
    poisson,    // exp(-s l): convolution with the Poisson kernel, which is positive
};

/// The factor of one band, in [0, 1], and 1 for band 0. Falls as the strength grows.
/// Source: Sloan, "Stupid Spherical Harmonics (SH) Tricks", 2008; the Poisson kernel is that of harmonic functions in a
///         ball.
///
/// strength  s >= 0; 0 leaves everything as it is; hann and lanczos leave only band 0 from s = 1 on
[[nodiscard]] double window_factor(ShWindow window, int band, double strength) noexcept;

/// Scales each band by its window_factor, in place.
void window_sh(std::span<glm::vec3> coefficients, ShWindow window, double strength) noexcept;
void window_sh(std::span<double> coefficients, ShWindow window, double strength) noexcept;

/// Windows radiance, in place, by the least strength with which irradiance_from_sh is nowhere negative (it then has its
/// minimum at 1e-5 of its mean: room for rounding to float). Irradiance that is nowhere negative stays as it is, to the
/// bit.
///
/// The Poisson window is the default because it keeps most: one distant light of 1 lx in 3 bands peaks at 1.0625 lx as
/// it comes, at 0.915 after the Poisson window, at 0.59 after laplacian, at 0.50 after hann and lanczos. Those take
/// band 2 away long before band 1, and band 1 alone is negative behind. Its kernel is positive, so that more strength
/// than the least is never too much.
///
/// All three channels get the same window, the strongest that one of them needs: the light is filtered as a whole and
/// its hues do not come apart. A channel that is negative on average cannot be helped by a window and becomes black.
///
/// Source:   the aim is that of Sloan, "Deringing Spherical Harmonics", 2017, for 3 bands. Here, for any bands, each
///           direction in which irradiance is negative tells the strength that it needs, until there is none.
/// returns   the strength; 0 if nothing was changed but channels that became black. A channel that is not finite asks
///           for none.
/// Cost:     3 bands: 5 us if nothing rings, 0.2 ms if it does; grows as bands^3.
double dering_sh(std::span<glm::vec3> radiance, ShWindow window = ShWindow::poisson);

}  // namespace lightgrid
