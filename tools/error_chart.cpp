#include "tools/error_chart.h"

#include "core/error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace lightgrid {
namespace {

constexpr double width = 960;
constexpr double height = 540;
constexpr double left = 84;  // of the curve's frame
constexpr double top = 84;
constexpr double right = 600;
constexpr double bottom = 466;

struct CurvePoint {
    double seconds, error, low, high;
};

/// A logarithmic axis from `first` to `last`, drawn from `start` to `end`.
struct Axis {
    double first, last, start, end;

    [[nodiscard]] double place(double value) const {
        return start + (end - start) * std::log(std::clamp(value, first, last) / first) / std::log(last / first);
    }
    /// Round numbers within the axis: 1, 2 and 5 times powers of ten, more where these are few.
    [[nodiscard]] std::vector<double> marks() const {
        const auto within = [&](std::initializer_list<double> steps) {
            std::vector<double> all;
            for (double decade = std::pow(10, std::floor(std::log10(first))); decade <= last; decade *= 10) {
                for (const double step : steps) {
                    if (step * decade >= first && step * decade <= last) all.push_back(step * decade);
                }
            }
            return all;
        };
        const std::vector<double> few = within({1, 2, 5});
        return few.size() >= 4 ? few : within({1, 1.5, 2, 3, 4, 5, 6, 8});
    }
};

std::string text(double x, double y, const std::string& what, const std::string& more = {}) {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" {}>{}</text>\n", x, y, more, what);
}

std::string line(double x0, double y0, double x1, double y1, const std::string& style) {
    return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n", x0, y0, x1, y1, style);
}

std::string percent(double share) {
    return fmt::format("{:.3g} %", 100 * share);
}

std::string frame(const Axis& x, const Axis& y) {
    std::string svg;
    for (const double value : x.marks()) {
        svg += line(x.place(value), top, x.place(value), bottom, "class=\"grid\"");
        svg += text(x.place(value), bottom + 20, fmt::format("{}", value), "text-anchor=\"middle\"");
    }
    for (const double value : y.marks()) {
        svg += line(left, y.place(value), right, y.place(value), "class=\"grid\"");
        svg += text(left - 10, y.place(value) + 4, percent(value), "text-anchor=\"end\"");
    }
    svg += text(0.5 * (left + right), bottom + 48, "seconds of gathering", "text-anchor=\"middle\" class=\"axis\"");
    svg += text(left, top - 16, "relative RMSE of irradiance at held-out points", "class=\"axis\"");
    return svg;
}

std::string curve(const std::vector<CurvePoint>& points, const Axis& x, const Axis& y) {
    std::string band;  // along the upper edge, and back along the lower
    std::string middle;
    std::string dots;
    for (const CurvePoint& point : points) {
        band += fmt::format("{:.1f},{:.1f} ", x.place(point.seconds), y.place(point.high));
        middle += fmt::format("{:.1f},{:.1f} ", x.place(point.seconds), y.place(point.error));
        dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" class=\"dot\"/>\n", x.place(point.seconds),
                            y.place(point.error));
    }
    for (auto point = points.rbegin(); point != points.rend(); ++point) {
        band += fmt::format("{:.1f},{:.1f} ", x.place(point->seconds), y.place(point->low));
    }
    return fmt::format("<polygon points=\"{}\" class=\"band\"/>\n<polyline points=\"{}\" class=\"curve\"/>\n{}", band,
                       middle, dots);
}

/// Error ~ seconds^-1/2 through the first point: what pure noise would do.
std::string noise_slope(const std::vector<CurvePoint>& points, const Axis& x, const Axis& y) {
    const CurvePoint& first = points.front();
    const double end = std::min(points.back().seconds, first.seconds * std::pow(first.error / y.first, 2));
    const double error = first.error * std::sqrt(first.seconds / end);
    const double at_x = x.place(end);
    const double at_y = y.place(error);
    // Beside the line's lower end, where the curve is not: to its right if there is room.
    const bool to_the_right = at_x < right - 180;
    return line(x.place(first.seconds), y.place(first.error), at_x, at_y, "class=\"slope\"") +
           text(to_the_right ? at_x + 8 : at_x - 24, at_y - 8, "noise alone, slope -1/2",
                to_the_right ? "class=\"note\"" : "text-anchor=\"end\" class=\"note\"");
}

/// A bar a part, with its interval; the parts add as squares.
std::string parts_chart(const nlohmann::json& error) {
    constexpr double from = 690;
    constexpr double to = 900;
    constexpr std::array<std::pair<const char*, const char*>, 4> names{{{"noise", "more samples lower it"},
                                                                        {"bands", "more bands lower it"},
                                                                        {"interpolation", "closer probes lower it"},
                                                                        {"storage", "half precision"}}};
    double largest = error["interval"][1].get<double>();
    for (const auto& [name, remedy] : names) {
        if (error["parts"][name].is_object())
            largest = std::max(largest, error["parts"][name]["interval"][1].get<double>());
    }
    const auto place = [&](double value) { return from + (to - from) * std::max(value, 0.0) / largest; };
    std::string svg = text(from, top - 16, "what the final error is made of", "class=\"axis\"");
    double y = top + 8;
    const auto bar = [&](const std::string& name, const nlohmann::json& part, const std::string& remedy,
                         const char* style) {
        const double value = part["relrmse"];
        const double low = part["interval"][0];
        const double high = part["interval"][1];
        svg += text(from, y, fmt::format("{} <tspan class=\"value\">{}</tspan>", name, percent(value)));
        svg += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"16\" {}/>\n", from, y + 8,
                           std::max(place(value) - from, 1.0), style);
        svg += line(place(low), y + 16, place(high), y + 16, "class=\"whisker\"");
        svg += text(from, y + 41, remedy, "class=\"note\"");
        y += 74;
    };
    bar("total", error, "with 95 % interval; parts add as squares", "class=\"total\"");
    for (const auto& [name, remedy] : names) {
        if (error["parts"][name].is_object()) bar(name, error["parts"][name], remedy, "class=\"part\"");
    }
    return svg;
}

}  // namespace

std::string error_chart(const nlohmann::json& report, const std::string& where) {
    std::vector<CurvePoint> points;
    double low = std::numeric_limits<double>::infinity();
    double high = 0;
    try {
        if (!report.at("error").at("relrmse").is_number()) {
            throw Error("holds no measured error", where, "Bake a volume with cells and --report-json");
        }
        for (const nlohmann::json& point : report.at("curve")) {
            const CurvePoint next{point.at("seconds"), point.at("relrmse"), point.at("interval").at(0),
                                  point.at("interval").at(1)};
            if (!(next.seconds > 0) || !(next.error > 0)) continue;  // neither has a logarithm
            points.push_back(next);
            high = std::max({high, next.error, next.high});
            low = std::min({low, next.error, next.low > 0 ? next.low : next.error});
        }
    } catch (const nlohmann::json::exception& problem) {
        throw Error(std::string("is no report of level-bake: ") + problem.what(), where,
                    "Give the file that --report-json wrote");
    }
    if (points.empty()) throw Error("its curve is empty", where, "Bake with more --samples");

    const Axis x{0.8 * points.front().seconds, std::max(1.25 * points.back().seconds, 2 * points.front().seconds), left,
                 right};
    const Axis y{0.8 * low, 1.25 * high, bottom, top};
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
        "font-family=\"system-ui, Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"#22252a\">\n"
        "<style>.grid{{stroke:#d9d6cf}} .axis{{font-weight:600}} .note{{fill:#7b7f86;font-size:12px}} "
        ".value{{font-weight:600}}\n"
        ".band{{fill:#1f6fb2;opacity:.18}} .curve{{fill:none;stroke:#1f6fb2;stroke-width:2.5}} .dot{{fill:#1f6fb2}}\n"
        ".slope{{stroke:#7b7f86;stroke-dasharray:6 5}} .part{{fill:#6dbe45}} .total{{fill:#1f6fb2}} "
        ".whisker{{stroke:#22252a;stroke-width:2}}</style>\n"
        "<rect width=\"{0}\" height=\"{1}\" fill=\"#f4f2ee\"/>\n",
        width, height);
    svg += text(left, 36, fmt::format("Error against time: {}", report.value("level", "")),
                "font-size=\"19\" font-weight=\"600\"");
    svg += frame(x, y) + curve(points, x, y) + noise_slope(points, x, y) + parts_chart(report["error"]);
    return svg + "</svg>\n";
}

}  // namespace lightgrid
