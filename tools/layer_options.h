#pragma once

#include "probes/volume.h"

#include <glm/glm.hpp>

#include <string>
#include <vector>

namespace lightgrid {

/// "lamps=2,signs=1,0.5,0" as a weight for each layer of a volume: one number, or one for each colour. Layers that are
/// not named are off. "sky=" gives the sky of a transfer, uniform radiance (cd/m^2) or the image of an environment.
///
/// Throws Error for what is no such list, and for layers that the volume does not have, listing those it has.
[[nodiscard]] std::vector<glm::vec3> parse_layer_weights(const std::string& text, const Volume& volume);

}  // namespace lightgrid
