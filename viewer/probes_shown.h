#pragma once

#include "viewer/draw_balls.h"
#include "viewer/draw_lines.h"
#include "viewer/look_up.h"

#include <glm/glm.hpp>

#include <vector>

/// A volume's probes and cells as things to draw. No OpenGL here.
namespace lightgrid {

/// All probes where they were gathered, a fifth of the spacing large, with rims that tell their states apart.
[[nodiscard]] std::vector<Ball> probe_balls(const LitVolume& volume, glm::dvec3 origin);

/// The cell that answers at a position.
struct ShownCell {
    std::vector<Ball> balls;     // its probes that answer, as large as their weights
    std::vector<LineEnd> lines;  // its edges, and from the position to the probes
};
/// Empty where no light is known.
[[nodiscard]] ShownCell cell_shown(const LookUp& from, glm::dvec3 position, glm::dvec3 origin);

}  // namespace lightgrid
