#pragma once

#include "probes/volume.h"
#include "tools/canvas.h"
#include "tools/lit_level.h"

#include <glm/glm.hpp>

#include <optional>
#include <string>

/// What `lightgrid draw` draws.
namespace lightgrid {

/// Of all probes, and the least distance between two of them along an axis, metres.
[[nodiscard]] Box bounds_of(const Volume& volume);
[[nodiscard]] double finest_spacing(const Volume& volume);

struct PictureOptions {
    glm::dvec3 at{0};               // the point that slices and cuts go through
    int width = 1280;               // pixels
    std::optional<float> exposure;  // per cd/m^2; none: automatic
};

/// The level from the camera, 16 : 9.
[[nodiscard]] Canvas draw_view(const LitLevel& level, const Camera& camera, const PictureOptions& options);

/// Mean irradiance in false colours in a plan and two sections through `at`, on one logarithmic scale in lux.
[[nodiscard]] Canvas draw_slices(const LitLevel& level, const Volume& volume, const PictureOptions& options);

/// The level cut open at the layer of probes nearest to `at`, with that layer as spheres of albedo 0.8 under their own
/// light; rings tell valid, moved and invalid probes apart. Seen from above, and from the front.
[[nodiscard]] Canvas draw_probes(const LitLevel& level, const Volume& volume, const PictureOptions& options);

}  // namespace lightgrid
