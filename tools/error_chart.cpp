#include "tools/error_chart.h"

#include "core/error.h"
#include "tools/markup.h"
#include "tools/plot.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace lightgrid {
namespace {

using nlohmann::json;

constexpr double left = 50;  // of the curve's frame
constexpr double right = plot_width - 6;
constexpr double top = 24;
constexpr double bottom = error_curve_height - 42;
/// Room below the floor for its name and that of the slope.
constexpr double below_floor = 40;
/// Farther than this many times the time that was spent, a forecast is not worth drawing.
constexpr double farthest_forecast = 64;

struct CurvePoint {
    double seconds, error, low, high;
};

std::vector<CurvePoint> curve_points(const json& report) {
    std::vector<CurvePoint> points;
    for (const json& point : report.at("curve")) {
        const CurvePoint next{point.at("seconds"), point.at("relrmse"), point.at("interval").at(0),
                              point.at("interval").at(1)};
        if (next.seconds > 0 && next.error > 0) points.push_back(next);  // others have no logarithm
    }
    return points;
}

/// What more samples do: total^2 = floor^2 + noise^2 * seconds spent / seconds.
struct Forecast {
    double floor = 0;
    double noise = 0;
    double spent = 0;  // seconds
    double until = 0;  // where half of the error is reached, or four times what was spent

    [[nodiscard]] double error(double seconds) const {
        return std::sqrt(floor * floor + noise * noise * spent / seconds);
    }
};

Forecast forecast_of(const json& report, double spent) {
    Forecast forecast;
    const json& halving = report.value("halving", json());
    if (!halving.is_object()) return forecast;
    const double total = report["error"]["relrmse"];
    forecast.floor = halving["floor"];
    forecast.noise = std::sqrt(std::max(total * total - forecast.floor * forecast.floor, 0.0));
    forecast.spent = spent;
    forecast.until = 4 * spent;
    if (halving["seconds"].is_number()) {
        forecast.until =
            std::max(forecast.until, std::min(halving["seconds"].get<double>(), farthest_forecast * spent));
    }
    return forecast;
}

std::string measured_curve(const std::vector<CurvePoint>& points, const Axis& x, const Axis& y) {
    std::string band;  // along the upper edge, and back along the lower
    std::string middle;
    std::string dots;
    for (const CurvePoint& point : points) {
        band += fmt::format("{:.1f},{:.1f} ", x.place(point.seconds), y.place(point.high));
        middle += fmt::format("{:.1f},{:.1f} ", x.place(point.seconds), y.place(point.error));
        dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" class=\"mark first\">{}</circle>\n",
                            x.place(point.seconds), y.place(point.error),
                            svg_title(fmt::format("{} ({} to {}) after {:.3g} s", percent_text(point.error),
                                                  percent_text(point.low), percent_text(point.high), point.seconds)));
    }
    for (auto point = points.rbegin(); point != points.rend(); ++point) {
        band += fmt::format("{:.1f},{:.1f} ", x.place(point->seconds), y.place(point->low));
    }
    return fmt::format("<polygon points=\"{}\" class=\"band\"/>\n<polyline points=\"{}\" class=\"curve\"/>\n{}", band,
                       middle, dots);
}

std::string forecast_curve(const Forecast& forecast, const Axis& x, const Axis& y) {
    constexpr int steps = 32;
    std::string points;
    for (int i = 0; i <= steps; ++i) {
        const double seconds =
            forecast.spent * std::pow(forecast.until / forecast.spent, static_cast<double>(i) / steps);
        points += fmt::format("{:.1f},{:.1f} ", x.place(seconds), y.place(forecast.error(seconds)));
    }
    return fmt::format("<polyline points=\"{}\" class=\"predicted\"/>\n", points);
}

/// Error ~ seconds^-1/2 through the first point: what pure noise would do.
std::string noise_slope(const CurvePoint& first, const Axis& x, const Axis& y) {
    const double end = std::min(x.last, first.seconds * std::pow(first.error / y.first, 2));
    const double at_x = x.place(end);
    const double at_y = y.place(first.error * std::sqrt(first.seconds / end));
    // Beside the line's lower end, where the curve is not: to its right if there is room.
    const bool to_the_right = at_x < right - 140;
    return svg_line(x.place(first.seconds), y.place(first.error), at_x, at_y, "class=\"slope\"") +
           svg_text(to_the_right ? at_x + 4 : at_x - 22, at_y - 6, "noise alone: slope -1/2",
                    to_the_right ? "class=\"note\"" : "text-anchor=\"end\" class=\"note\"");
}

std::string floor_line(double floor, const Axis& x, const Axis& y) {
    return svg_line(x.start, y.place(floor), x.end, y.place(floor), "class=\"floor\"") +
           svg_text(x.end, y.place(floor) + 14, "more samples cannot go below " + percent_text(floor),
                    "text-anchor=\"end\" class=\"note floor-note\"");
}

}  // namespace

std::string error_curve(const json& report) {
    const std::vector<CurvePoint> points = curve_points(report);
    if (points.empty()) return {};
    const Forecast forecast = forecast_of(report, points.back().seconds);
    std::vector<double> seconds{2 * points.front().seconds, forecast.until};
    std::vector<double> errors;
    for (const CurvePoint& point : points) {
        seconds.push_back(point.seconds);
        errors.insert(errors.end(), {point.error, point.low, point.high});
    }
    if (forecast.noise > 0) errors.push_back(forecast.error(forecast.until));
    const Axis x = axis_around(seconds, left, right);
    Axis y = axis_around(errors, bottom, top);
    if (forecast.floor > 0) {
        // So low that the floor is at least below_floor above the lower end.
        const double share = below_floor / (bottom - top);
        y.first = std::min(y.first, std::exp((std::log(forecast.floor) - share * std::log(y.last)) / (1 - share)));
    }
    std::string svg = plot_frame(x, y, "seconds of gathering", "relative RMSE of irradiance", true);
    if (forecast.floor > 0) svg += floor_line(forecast.floor, x, y);
    svg += noise_slope(points.front(), x, y);
    if (forecast.noise > 0) svg += forecast_curve(forecast, x, y);
    return svg + measured_curve(points, x, y);
}

std::string error_parts(const json& report) {
    const json& error = report.at("error");
    const auto bar = [](const std::string& name, const json& part) {
        return Bar{name, percent_text(part["relrmse"]), "", part["relrmse"], part["interval"][0], part["interval"][1]};
    };
    std::vector<Bar> rows;
    for (const auto& [name, part] : error.at("parts").items()) {
        if (part.is_object()) rows.push_back(bar(name, part));
    }
    std::stable_sort(rows.begin(), rows.end(), [](const Bar& a, const Bar& b) { return a.value > b.value; });
    if (error.at("relrmse").is_number()) {
        rows.insert(rows.begin(), bar("total", error));
        rows.front().emphasis = true;
    }
    return svg_plot(bars_height(rows), "Parts of the error", bars(rows, 0));
}

std::string error_chart(const json& report, const std::string& where) {
    std::string curve;
    std::string parts;
    try {
        if (!report.at("error").at("relrmse").is_number()) {
            throw Error("holds no measured error", where, "Bake a volume with cells and --report-json");
        }
        curve = error_curve(report);
        parts = error_parts(report);
    } catch (const json::exception& problem) {
        throw Error(std::string("is no report of level-bake: ") + problem.what(), where,
                    "Give the file that --report-json wrote");
    }
    if (curve.empty()) throw Error("its curve is empty", where, "Bake with more --samples");

    const PlotColors colors{"#22252a", "#6b7078", "#d9d6cf", "#f4f2ee", "#1f6fb2", "#b8621b"};
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 960 420\" width=\"960\" height=\"420\" "
        "font-family=\"system-ui, Helvetica, Arial, sans-serif\">\n<style>{}</style>\n"
        "<rect width=\"960\" height=\"420\" fill=\"{}\"/>\n"
        "<text x=\"28\" y=\"40\" font-size=\"19\" font-weight=\"600\" fill=\"{}\">Error against time: {}</text>\n"
        "<svg x=\"28\" y=\"64\" width=\"440\" height=\"330\" viewBox=\"0 0 400 300\" class=\"plot\">\n{}</svg>\n"
        "<text x=\"560\" y=\"90\" font-size=\"13\" font-weight=\"600\" fill=\"{}\">What it is made of (parts add as "
        "squares)</text>\n<g transform=\"translate(530 104) scale(0.9)\">{}</g>\n</svg>\n",
        plot_style(colors), colors.paper, colors.ink, escape(report.value("level", "")), curve, colors.ink, parts);
}

}  // namespace lightgrid
