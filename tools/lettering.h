#pragma once

#include <glm/glm.hpp>

#include <string>
#include <vector>

namespace lightgrid {

struct Stroke {
    glm::vec2 from;
    glm::vec2 to;
};

/// A line of text as strokes of a pen.
struct Lettering {
    std::vector<Stroke> strokes;
    float width = 0;  // up to where the next letter would stand
};

/// Letters, digits and . , : = + - / ( ) % stand on y = cap_height, right of x = 0; other characters are gaps.
[[nodiscard]] Lettering letter(const std::string& text, float cap_height);

}  // namespace lightgrid
