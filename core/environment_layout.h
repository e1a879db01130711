#pragma once

#include "core/image.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <string_view>

namespace lightgrid {

/// How a picture covers the sphere of directions. All are seen from inside, not mirrored, but for `strip`.
///
/// equirectangular   the project's own: centre column +X, u grows towards +Z, top row +Y; any size.
/// vertical_cross    3:4, faces     +Y        The middle column is one band: -Z below +Y, and +Z upside down at the end
///                              -X  -Z  +X    (Debevec's Light Probe Image Gallery, HDR Shop).
///                                  -Y
///                                  +Z
/// horizontal_cross  4:3, faces     +Y        The middle row is one band.
///                              -X  -Z  +X  +Z
///                                  -Y
/// strip             6:1 or 1:6, faces +X -X +Y -Y +Z -Z, each turned as OpenGL, Vulkan and KTX turn the faces of
///                   a cube map whose lookup vector is the direction (OpenGL 4.6 core, table 8.19); so they look mirrored.
/// angular           square, Debevec's angular map: the centre is -Z, +X is right, +Y up, the distance from the centre
///                   is proportional to the angle from -Z, and the circle that touches the edges is +Z.
/// openexr_latlong   ImfEnvmap.h: the centre is +Z, u grows towards -X, the top row is +Y itself and the first and last
///                   column both are -Z: pixel centres reach the edges.
/// openexr_cube      1:6, ImfEnvmap.h: faces +X -X +Y -Y +Z -Z from the top; pixel centres reach the edges of a face.
enum class EnvironmentLayout : std::uint8_t {
    automatic,
    equirectangular,
    vertical_cross,
    horizontal_cross,
    strip,
    angular,
    openexr_latlong,
    openexr_cube,
};

/// "auto", "equirect", "vertical-cross", "horizontal-cross", "strip", "angular", "openexr-latlong", "openexr-cube".
/// Throws Error that lists them.
[[nodiscard]] EnvironmentLayout parse_environment_layout(std::string_view name);
[[nodiscard]] std::string_view name_of(EnvironmentLayout layout) noexcept;

/// The layout that an image of this shape most probably has; `automatic` where none fits. 2:1 within 1 % is
/// equirectangular, a square is angular.
[[nodiscard]] EnvironmentLayout layout_of_shape(int width, int height) noexcept;

/// The same light as an equirectangular image, fine enough for the smallest details of the source: a face of n pixels
/// gives 4n x 2n, an angular map of n pixels 2n x n, latlong its own size. Pixels are averages over their solid angle
/// of the source, interpolated bilinearly within a face; more samples are taken where it varies. Energy is kept to 0.5
/// % of SH coefficients up to band 2.
///
/// layout  not automatic; equirectangular returns the image itself
/// Throws Error where the size does not fit the layout.
[[nodiscard]] RadianceImage to_equirectangular(RadianceImage image, EnvironmentLayout layout);

}  // namespace lightgrid
