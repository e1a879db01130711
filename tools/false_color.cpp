#include "tools/false_color.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lightgrid {

const std::array<glm::vec3, 8>& false_color_ramp() {
    static const std::array<glm::vec3, 8> ramp{hex_color(0x14123A), hex_color(0x2B2F8F), hex_color(0x1F6FB2),
                                               hex_color(0x1FA39A), hex_color(0x6DBE45), hex_color(0xE3CF3A),
                                               hex_color(0xF59E42), hex_color(0xFFF0DC)};
    return ramp;
}

glm::vec3 false_color(float place) {
    const std::array<glm::vec3, 8>& ramp = false_color_ramp();
    const float at = glm::clamp(place, 0.0F, 1.0F) * (ramp.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(at), ramp.size() - 2);
    return glm::mix(ramp[below], ramp[below + 1], at - static_cast<float>(below));
}

double mark(int number) {
    constexpr std::array<double, 3> steps{1, 2, 5};
    const int decade = static_cast<int>(std::floor(number / 3.0));
    return steps[number - 3 * decade] * std::pow(10.0, decade);
}

int mark_below(double value) {
    int number = 3 * static_cast<int>(std::floor(std::log10(value)));
    while (mark(number + 1) <= value) ++number;
    return number;
}

double LogScale::place(double value) const {
    return std::log(std::max(value, 1e-30) / marks.front()) / std::log(marks.back() / marks.front());
}

LogScale scale_of(std::vector<float> values) {
    std::erase_if(values, [](float value) { return !(value > 0); });
    int first = 0;
    int last = 1;
    if (!values.empty()) {
        std::sort(values.begin(), values.end());
        const std::size_t cut = values.size() / 200;
        first = mark_below(values[cut]);
        last = std::max(mark_below(values[values.size() - 1 - cut]) + 1, first + 1);
    }
    LogScale scale;
    for (int number = first; number <= last; ++number) scale.marks.push_back(mark(number));
    return scale;
}

void draw_legend(Canvas& canvas, glm::ivec2 corner, int height, const LogScale& scale, const std::string& unit,
                 glm::vec3 ink) {
    constexpr int bar = 26;
    constexpr int line_height = 24;
    constexpr double room_for_text = 14;
    const bool crowded = height < room_for_text * static_cast<double>(scale.marks.size() - 1);
    for (int y = 0; y < height; ++y) {
        canvas.fill(corner + glm::ivec2(0, y), {bar, 1},
                    false_color(1 - static_cast<float>(y) / static_cast<float>(height - 1)));
    }
    for (const double number : scale.marks) {
        const int y = corner.y + static_cast<int>(std::lround((1 - scale.place(number)) * (height - 1)));
        canvas.fill({corner.x + bar, y}, {7, 1}, ink);
        const double decade = std::log10(number);
        const bool round = std::abs(decade - std::round(decade)) < 0.1;  // 1, not 2 or 5
        if (round || !crowded) canvas.text({corner.x + bar + 12, y - 5}, fmt::format("{}", number), ink);
    }
    canvas.text({corner.x, corner.y - line_height}, unit, ink);
}

glm::vec3 state_color(ProbeState state) {
    switch (state) {
        case ProbeState::valid:
            return hex_color(0x4FB286);
        case ProbeState::moved:
            return hex_color(0xF2B134);
        case ProbeState::filled:
            return hex_color(0xE5484D);
        default:
            return hex_color(0xB04FC6);
    }
}

}  // namespace lightgrid
