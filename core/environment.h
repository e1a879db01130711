#pragma once

#include "core/image.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <optional>
#include <vector>

namespace lightgrid {

/// A bright disc at infinity, of constant radiance.
struct SunDisc {
    glm::vec3 direction{0, 1, 0};  // towards its centre, unit length
    float angular_radius = 0;      // radians, (0, pi/2]
    glm::vec3 radiance{0};         // cd/m^2, added to what lies behind it

    [[nodiscard]] double solid_angle() const;  // steradians: 4 pi sin^2(angular_radius / 2)
};

/// Radiance arriving from infinity: a uniform sky, an equirectangular image, or an image with a sun disc. Immutable;
/// any number of threads.
///
/// Equirectangular: the centre column is +X, u grows from +X towards +Z, the top row is +Y. Bilinear in the two angles
/// between pixel centres, which lie at (i + 1/2) / size; beyond the centres of the first and last row it is constant
/// towards the pole; so the pixels of these two rows weigh 8 % more than their solid angle, all others the same.
///
/// Directions are drawn in proportion to the luminance of that bilinear function, so that radiance / pdf is constant
/// for a grey environment but for a factor in [2/3, 2] within two rows of a pole and of 1 + O(1 / height) elsewhere:
/// one pixel of 1e6 in a dark sky is no harder than a uniform one.
///
/// Memory: 17 bytes a pixel (12 of it the image) and 32 a row. Cost of a sample: O(1) but between rows that share
/// nothing, then O(log width).
class Environment {
  public:
    struct Sample {
        glm::vec3 direction{0};
        glm::vec3 radiance{0};
        float pdf = 0;  // per steradian; 0: nothing to sample
    };

    /// Black.
    Environment() = default;

    /// The same radiance from everywhere. Throws Error where it is not finite or negative.
    [[nodiscard]] static Environment uniform(glm::vec3 radiance);

    /// An image, and a sun on top of it; both turned and scaled.
    ///
    /// equirectangular  at least 1 x 1, finite, not negative
    /// rotation_deg     turns the surroundings counter-clockwise about +Y seen from above: 90 brings what was at +X to
    /// -Z scale            multiplies all radiance; finite, not negative
    ///
    /// An image of one colour without a sun becomes a uniform sky. Throws Error naming the pixel that is not finite or
    /// negative, or if the whole is too bright for float (its radiance integrated over the sphere above 1e25).
    [[nodiscard]] static Environment from_image(RadianceImage equirectangular, float rotation_deg = 0, float scale = 1,
                                                std::optional<SunDisc> sun = {});

    [[nodiscard]] bool is_black() const noexcept;
    /// The same from everywhere: nothing to gain from importance sampling.
    [[nodiscard]] bool is_uniform() const noexcept;

    /// Environments of the same shape differ by a factor, that of their scales: a number that tells all else apart.
    [[nodiscard]] std::uint64_t shape() const noexcept { return shape_; }
    [[nodiscard]] glm::vec3 scale() const noexcept { return scale_; }

    /// direction  unit length to 1e-4
    [[nodiscard]] glm::vec3 radiance(glm::vec3 direction) const noexcept;

    /// Draws a direction in proportion to luminance (see above); the sun disc by its share of the whole.
    ///
    /// u  in [0, 1)^3: x chooses between image and sun, (y, z) the place. Continuous in (y, z), so that stratified
    ///    points stay stratified.
    [[nodiscard]] Sample sample(glm::vec3 u) const noexcept;

    /// Density of `sample` at `direction`, per steradian; positive wherever the radiance is. Bit for bit what `sample`
    /// returned with that direction.
    [[nodiscard]] float pdf(glm::vec3 direction) const noexcept;

    /// Radiance and density at once, for little more than either costs.
    [[nodiscard]] Sample look_up(glm::vec3 direction) const noexcept;

  private:
    /// A row of cells between two rows of pixel centres (or a pole). `depth` is the distance from the nearer pole along
    /// the axis, 1 - |y|: exact where y itself would round.
    struct CellRow {
        float depth_above = 0;  // at the upper edge, t = 0
        float depth_below = 0;  // at the lower edge, t = 1
        float cumulative = 0;   // power of all rows above
        float sum_above = 0;    // luminance of the pixel rows at its edges, summed along them
        float sum_below = 0;
    };

    /// Where a direction falls between the pixel centres: four pixels and the weights of the right and lower ones.
    struct Place {
        int left = 0, right = 0, above = 0, below = 0;
        float x = 0;      // by azimuth
        float y = 0;      // by polar angle: for radiance
        float depth = 0;  // by solid angle: for the density
    };

    /// Fills the tables below from image_; returns its power.
    double tabulate();
    [[nodiscard]] Place place_of(glm::vec3 direction) const noexcept;
    [[nodiscard]] glm::vec3 image_direction(glm::vec2 u) const noexcept;
    [[nodiscard]] glm::vec3 sun_direction(glm::vec2 u) const noexcept;
    [[nodiscard]] bool in_sun(glm::vec3 direction) const noexcept;

    std::uint64_t shape_ = 0;
    glm::vec3 scale_{0};
    glm::vec3 uniform_{0};  // meaningful where there is no image
    RadianceImage image_;
    std::vector<CellRow> rows_;                 // height + 1
    std::vector<std::uint32_t> row_guide_;      // where to search in rows_
    std::vector<float> column_sums_;            // per pixel row width + 1: luminance integrated from the first centre
    std::vector<std::uint32_t> column_guides_;  // per pixel row: where to search in it
    float image_power_ = 0;                     // luminance of the image integrated over the sphere, cd/m^2 sr
    float columns_per_radian_ = 0;
    float first_column_ = 0;  // column coordinate of azimuth 0, towards +X
    SunDisc sun_;
    float sun_chord_squared_ = -1;  // squared distance between unit vectors at its rim; -1: there is no sun
    float sun_share_ = 0;           // of the whole power
    float inverse_power_ = 0;       // 1 / power of image and sun
};

}  // namespace lightgrid
