#include "tools/lettering.h"

#include <algorithm>
#include <string_view>

namespace lightgrid {
namespace {

/// Points x, y in base 17 (0-9, a-g) that the pen joins; a space lifts it. Capitals reach from y = 0 to the base line
/// 12, small letters from 4, what hangs below to 16.
std::string_view glyph(char letter) {
    switch (letter) {
        case '0':
            return "205073795c2c090320";
        case '1':
            return "03303c";
        case '2':
            return "0220507274560c7c";
        case '3':
            return "0220507274563656787a5c2c0a";
        case '4':
            return "5c500878";
        case '5':
            return "7010052454767a5c2c0a";
        case '6':
            return "61502003092c5c7a77552507";
        case '7':
            return "00702c";
        case '8':
            return "250402205072745525070a2c5c7a7755";
        case '9':
            return "1b2c5c797350200205275775";
        case 'a':
            return "2454767a5c2c0a0624 747c";
        case 'b':
            return "000c 062454767a5c2c0a";
        case 'c':
            return "765424060a2c5c7a";
        case 'd':
            return "707c 765424060a2c5c7a";
        case 'e':
            return "0878765424060a2c5c7b";
        case 'f':
            return "5031232c 0454";
        case 'g':
            return "765424060a2c5c7a 747e5g2g0f";
        case 'h':
            return "000c 062454767c";
        case 'i':
            return "040c 0001";
        case 'j':
            return "242e0g 2021";
        case 'k':
            return "000c 6409 276c";
        case 'l':
            return "000c";
        case 'm':
            return "040c 062434565c 567484a6ac";
        case 'n':
            return "040c 062454767c";
        case 'o':
            return "2454767a5c2c0a0624";
        case 'p':
            return "040g 062454767a5c2c0a";
        case 'q':
            return "747g 765424060a2c5c7a";
        case 'r':
            return "040c 072544";
        case 's':
            return "65442405072848696b4c2c0b";
        case 't':
            return "202a4c5c 0454";
        case 'u':
            return "040a2c5c7a 747c";
        case 'v':
            return "043c64";
        case 'w':
            return "042c548ca4";
        case 'x':
            return "046c 640c";
        case 'y':
            return "043c 643c1g0g";
        case 'z':
            return "04640c6c";
        case 'A':
            return "0c408c 1979";
        case 'B':
            return "000c5c7a785606 5674725000";
        case 'C':
            return "82603003093c6c8a";
        case 'D':
            return "000c4c79734000";
        case 'E':
            return "70000c7c 0656";
        case 'F':
            return "70000c 0656";
        case 'G':
            return "82603003093c6c898757";
        case 'H':
            return "000c 808c 0686";
        case 'I':
            return "000c";
        case 'J':
            return "505a3c1c0a";
        case 'K':
            return "000c 7007 347c";
        case 'L':
            return "000c6c";
        case 'M':
            return "0c0048808c";
        case 'N':
            return "0c008c80";
        case 'O':
            return "306083896c3c090330";
        case 'P':
            return "0c005072755707";
        case 'Q':
            return "306083896c3c090330 699d";
        case 'R':
            return "0c005072755707 377c";
        case 'S':
            return "72502002042656787a5c2c0a";
        case 'T':
            return "0080 404c";
        case 'U':
            return "00092c5c7970";
        case 'V':
            return "004c80";
        case 'W':
            return "003c508ca0";
        case 'X':
            return "007c 700c";
        case 'Y':
            return "004680 464c";
        case 'Z':
            return "00700c7c";
        case '.':
            return "0b0c";
        case ',':
            return "1b0e";
        case ':':
            return "0506 0b0c";
        case '=':
            return "0666 0969";
        case '+':
            return "0767 343a";
        case '-':
            return "0757";
        case '/':
            return "600d";
        case '(':
            return "20030a2d";
        case ')':
            return "00232a0d";
        case '%':
            return "700c 1021120110 6b7a695a6b";
        default:
            return "";
    }
}

float digit(char c) {
    return static_cast<float>(c <= '9' ? c - '0' : c - 'a' + 10);
}

}  // namespace

Lettering letter(const std::string& text, float cap_height) {
    constexpr float gap = 4;
    const float unit = cap_height / 12;
    Lettering lettering;
    for (const char c : text) {
        const std::string_view points = glyph(c);
        float reach = points.empty() ? 1 : 0;
        bool pen_down = false;
        glm::vec2 last(0);
        for (std::size_t i = 0; i < points.size();) {
            if (points[i] == ' ') {
                pen_down = false;
                ++i;
                continue;
            }
            const glm::vec2 next(digit(points[i]), digit(points[i + 1]));
            const glm::vec2 shift(lettering.width, 0);
            if (pen_down) lettering.strokes.push_back({unit * last + shift, unit * next + shift});
            reach = std::max(reach, next.x);
            last = next;
            pen_down = true;
            i += 2;
        }
        lettering.width += unit * (reach + gap);
    }
    return lettering;
}

}  // namespace lightgrid
