#pragma once

#include "probes/volume.h"
#include "tools/canvas.h"

#include <glm/glm.hpp>

#include <array>
#include <string>
#include <vector>

/// What numbers and states look like in our pictures: the same colours everywhere. sRGB in [0, 1].
namespace lightgrid {

/// Dark blue through cyan, green, yellow and red to pale: the order that lighting engineers know, with lightness rising
/// throughout so that it reads in grey, too. Colours between are mixed in sRGB.
[[nodiscard]] const std::array<glm::vec3, 8>& false_color_ramp();

/// place  0: the first colour, 1: the last; clamped
[[nodiscard]] glm::vec3 false_color(float place);

/// 1, 2 or 5 times a power of ten: the mark with this number; 0 is 1, 3 is 10.
[[nodiscard]] double mark(int number);
/// The last mark that is not above `value`, which is positive.
[[nodiscard]] int mark_below(double value);

/// A logarithmic scale between two round numbers.
struct LogScale {
    std::vector<double> marks;  // ascending: 1, 2 and 5 times powers of ten; the ends of the scale and all between

    [[nodiscard]] double place(double value) const;  // 0 at the first mark, 1 at the last; below and above for the rest
};

/// From mark to mark around all but the least and the largest 0.5 % of the values that are positive; from 1 to 2 where
/// none is.
[[nodiscard]] LogScale scale_of(std::vector<float> values);

/// The colour bar with its marks, its upper left corner at `corner`, and the unit above it.
void draw_legend(Canvas& canvas, glm::ivec2 corner, int height, const LogScale& scale, const std::string& unit,
                 glm::vec3 ink);

[[nodiscard]] glm::vec3 state_color(ProbeState state);

}  // namespace lightgrid
