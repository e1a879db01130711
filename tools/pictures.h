#pragma once

#include "probes/volume.h"
#include "tools/canvas.h"
#include "tools/false_color.h"
#include "tools/lit_level.h"

#include <glm/glm.hpp>

#include <optional>
#include <string>
#include <vector>

/// What `lightgrid draw` draws.
namespace lightgrid {

/// Of all probes, and the least distance between two of them along an axis, level coordinates.
[[nodiscard]] Box bounds_of(const Volume& volume);
[[nodiscard]] double finest_spacing(const Volume& volume);

struct PictureOptions {
    glm::dvec3 at{0};               // the point that slices and cuts go through
    int width = 1280;               // pixels
    std::optional<float> exposure;  // per cd/m^2; none: automatic
};

/// The level from the camera, 16 : 9.
[[nodiscard]] Canvas draw_view(const LitLevel& level, const Camera& camera, const PictureOptions& options);

/// A plane of the volume, seen along -axis: 1: plan, from above, X to the right; 2: X to the right, Y up; 0: -Z to the
/// right, Y up.
struct Slice {
    int axis = 1;
    double position = 0;  // of the plane
    Box box;              // of the volume
    double scale = 1;     // pixels per unit of the level

    [[nodiscard]] int right() const { return axis == 0 ? 2 : 0; }
    [[nodiscard]] int up() const { return axis == 1 ? 2 : 1; }
    [[nodiscard]] glm::ivec2 size() const;
    [[nodiscard]] glm::dvec3 point(glm::dvec2 pixel) const;  // pixels, from the upper left corner
    [[nodiscard]] glm::dvec2 pixel(glm::dvec3 point) const;  // where its projection onto the plane is
    [[nodiscard]] std::string title() const;
};

/// Planes through a point: mean irradiance in false colours with a contour at each mark, outlines, solids dark. Planes
/// in which the volume has no extent are left out.
struct SlicePictures {
    std::vector<Slice> slices;
    std::vector<Canvas> pictures;  // one each
    LogScale lux;
};
/// scale  of all pictures
[[nodiscard]] SlicePictures picture_slices(const LitLevel& level, const Volume& volume, glm::dvec3 at, double scale);

/// Mean irradiance in false colours in a plan and two sections through `at`, on one logarithmic scale in lux.
[[nodiscard]] Canvas draw_slices(const LitLevel& level, const Volume& volume, const PictureOptions& options);

/// The level cut open at the layer of probes nearest to `at`, with that layer as spheres of albedo 0.8 under their own
/// light; rings tell valid, moved and invalid probes apart. Seen from above, and from the front.
[[nodiscard]] Canvas draw_probes(const LitLevel& level, const Volume& volume, const PictureOptions& options);

}  // namespace lightgrid
