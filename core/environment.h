#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "core/image.h"

namespace lightgrid {

/// A bright disc at infinity, of constant radiance.
struct SunDisc {
    glm::vec3 direction{0, 1, 0};  // towards the sun, unit length
    float cos_radius = 1;          // cosine of its angular radius
    glm::vec3 radiance{0};         // cd/m^2
};

/// Radiance arriving from infinity: a uniform sky, an equirectangular image, or an image with a sun disc. Immutable.
///
/// Equirectangular: the centre column is +X, u grows from +X towards +Z, the top row is +Y; bilinear between pixel
/// centres, which lie at (i + 1/2) / size.
class Environment {
  public:
    struct Sample {
        glm::vec3 direction{0};
        glm::vec3 radiance{0};
        float pdf = 0;  // per steradian; 0: nothing to sample
    };

    /// Black.
    Environment() = default;
    /// The same radiance from everywhere.
    [[nodiscard]] static Environment uniform(glm::vec3 radiance);
    /// An equirectangular image, turned counter-clockwise about +Y seen from above, and scaled.
    [[nodiscard]] static Environment from_image(RadianceImage equirectangular, float rotation_deg = 0, float scale = 1,
                                                std::optional<SunDisc> sun = {});

    [[nodiscard]] bool is_black() const noexcept;
    /// The same from everywhere: nothing to gain from importance sampling.
    [[nodiscard]] bool is_uniform() const noexcept;

    [[nodiscard]] glm::vec3 radiance(glm::vec3 direction) const noexcept;

    /// Draws a direction roughly in proportion to luminance; `radiance` includes the sun disc where it is hit.
    /// u  three numbers in [0, 1)
    [[nodiscard]] Sample sample(glm::vec3 u) const noexcept;
    /// Density of `sample` at `direction`, per steradian; positive wherever the radiance is.
    [[nodiscard]] float pdf(glm::vec3 direction) const noexcept;

  private:
    glm::vec3 uniform_{0};
};

}  // namespace lightgrid
