#pragma once

#include "core/tracer.h"
#include "probes/volume.h"

#include <vector>

namespace lightgrid {

/// Materials of drawn outlines: black shells around things, turned inside out, which are only to be seen from their
/// front (an artist's trick that renderers without back-face culling spoil). One is known by how it looks from the
/// volume's valid probes: nearly always from behind, and close behind it the front of something else. Winding alone
/// would tell nothing: in many levels walls are turned, too.
///
/// returns  for each of Scene::materials
[[nodiscard]] std::vector<bool> find_outlines(const Tracer& tracer, const Volume& volume);

}  // namespace lightgrid
