#pragma once

#include <glm/glm.hpp>

#include <set>
#include <string>
#include <vector>

namespace lightgrid {

/// Keys by what an American keyboard prints on them; numbers as GLFW has them, which are ASCII where they can be.
enum class Key : int {
    space = 32,
    comma = 44,
    minus = 45,
    period = 46,
    digit_0 = 48,
    digit_1 = 49,
    digit_2 = 50,
    digit_3 = 51,
    digit_4 = 52,
    equal = 61,
    a = 65,
    b = 66,
    c = 67,
    d = 68,
    e = 69,
    f = 70,
    g = 71,
    h = 72,
    i = 73,
    j = 74,
    k = 75,
    l = 76,
    m = 77,
    n = 78,
    o = 79,
    p = 80,
    q = 81,
    r = 82,
    s = 83,
    t = 84,
    u = 85,
    v = 86,
    w = 87,
    x = 88,
    y = 89,
    z = 90,
    left_bracket = 91,
    right_bracket = 93,
    escape = 256,
    tab = 258,
    f1 = 290,
    f12 = 301,
    left_shift = 340,
    right_shift = 344,
};

enum class MouseButton : int { left = 0, right = 1, middle = 2 };

/// What a person did since the last frame.
struct Input {
    std::vector<Key> pressed;  // in this order; without repeats of held keys
    std::set<Key> held;        // down now
    std::set<MouseButton> buttons;
    std::vector<MouseButton> clicked;  // pressed since the last frame
    glm::dvec2 cursor{0};              // pixels of the framebuffer from its upper left corner
    glm::dvec2 moved{0};               // of the cursor, likewise
    double wheel = 0;                  // notches, away from the person positive
    std::vector<std::string> dropped;  // paths of files
};

}  // namespace lightgrid
