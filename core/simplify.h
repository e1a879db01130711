#pragma once

#include "core/scene.h"

namespace lightgrid {

/// Takes out of a scene what no light path can tell from its absence, and lists it in scene.left_out:
///
/// - alpha tests of materials whose alpha, the product of the least factor, texel and vertex alpha, lets nothing pass;
/// - surfaces whose alpha lets everything pass;
/// - textures of a single colour, which become factors, and emission that its texture makes black;
/// - vertex colours that are white, and textures and UV sets that nothing reads any more.
///
/// Meshes keep their places; those that cannot be seen keep no triangles.
void simplify(Scene& scene);

}  // namespace lightgrid
