#include "tools/cost_charts.h"

#include "tools/markup.h"
#include "tools/plot.h"
#include "tools/progress.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

namespace lightgrid {
namespace {

using nlohmann::json;

/// Less than half a percent less error is no reason to pay more.
constexpr double worth_joining = 0.995;
constexpr double height = 310;
constexpr double left = 50;
constexpr double right = plot_width - 12;
constexpr double top = 46;
constexpr double bottom = height - 42;

struct Choice {
    double cost = 0;
    double error = 0;
    double low = 0;
    double high = 0;
    bool trilinear = false;
    bool half = false;
    bool this_bake = false;
    std::string name;
};

std::vector<Choice> choices(const json& report, const char* cost) {
    std::vector<Choice> all;
    for (const json& look_up : report.at("look_ups")) {
        const Choice choice{look_up.at(cost),
                            look_up.at("relrmse"),
                            look_up.at("interval").at(0),
                            look_up.at("interval").at(1),
                            look_up.at("interpolation") == "trilinear",
                            look_up.at("storage") == "half",
                            look_up.at("this_bake"),
                            fmt::format("L{}", look_up.at("bands").get<int>() - 1)};
        if (choice.cost > 0 && choice.error > 0) all.push_back(choice);  // others have no logarithm
    }
    return all;
}

/// A disc for trilinear, a square for nearest; filled for float, hollow for half.
std::string symbol(double x, double y, const Choice& choice, const std::string& title, const char* role) {
    const char* look = choice.trilinear ? "first" : "second";
    const char* hollow = choice.half ? " hollow" : "";
    return choice.trilinear
               ? fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4.5\" class=\"{} {}{}\">{}</circle>\n", x, y,
                             role, look, hollow, title)
               : fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"8\" height=\"8\" class=\"{} {}{}\">{}</rect>\n",
                             x - 4, y - 4, role, look, hollow, title);
}

std::string key(bool with_half) {
    std::string svg;
    double x = 8;
    const auto entry = [&](bool trilinear, bool half, const std::string& name) {
        Choice shown;
        shown.trilinear = trilinear;
        shown.half = half;
        svg += symbol(x, 10, shown, "", "key") + svg_text(x + 9, 14, name);
        x += 9 + 5.8 * static_cast<double>(name.size()) + 16;
    };
    entry(true, false, with_half ? "trilinear, float" : "trilinear");
    if (with_half) entry(true, true, "half");
    entry(false, false, with_half ? "nearest, float" : "nearest");
    if (with_half) entry(false, true, "half");
    return svg;
}

/// Joins what nothing beats in both cost and error: at each cost the least error so far.
std::string pareto_front(std::vector<Choice> all, const Axis& x, const Axis& y) {
    std::sort(all.begin(), all.end(),
              [](const Choice& a, const Choice& b) { return std::pair(a.cost, a.error) < std::pair(b.cost, b.error); });
    double least = std::numeric_limits<double>::infinity();
    std::string steps;
    for (const Choice& choice : all) {
        if (choice.error >= worth_joining * least) continue;
        if (!steps.empty()) steps += fmt::format("{:.1f},{:.1f} ", x.place(choice.cost), y.place(least));
        steps += fmt::format("{:.1f},{:.1f} ", x.place(choice.cost), y.place(choice.error));
        least = choice.error;
    }
    return fmt::format("<polyline points=\"{}\" class=\"front\"/>\n", steps);
}

std::string look_up_plot(const std::vector<Choice>& all, const char* cost_name, const std::string& label,
                         bool with_half) {
    if (all.empty()) return {};
    std::vector<double> costs;
    std::vector<double> errors;
    for (const Choice& choice : all) {
        costs.push_back(choice.cost);
        errors.push_back(choice.error);
    }
    const Axis x = axis_around(costs, left, right);
    const Axis y = axis_around(errors, bottom, top);
    std::string svg = key(with_half) + plot_frame(x, y, cost_name, "relative RMSE", true) + pareto_front(all, x, y);
    for (const Choice& choice : all) {
        const double at_x = x.place(choice.cost);
        const double at_y = y.place(choice.error);
        if (choice.this_bake) {
            svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"10\" class=\"this\"/>\n", at_x, at_y);
        }
        const std::string title =
            fmt::format("{}, {}, {}: {} ({} to {}), {:.3g} {}", choice.name, choice.trilinear ? "trilinear" : "nearest",
                        choice.half ? "half" : "float", percent_text(choice.error), percent_text(choice.low),
                        percent_text(choice.high), choice.cost, cost_name);
        svg += symbol(at_x, at_y, choice, svg_title(title), "mark");
        // Names on the sides where their neighbours, at other bands and half the bytes, are not.
        svg += choice.trilinear ? svg_text(at_x - 7, at_y + 16, choice.name, "text-anchor=\"end\" class=\"note\"")
                                : svg_text(at_x + 7, at_y - 7, choice.name, "class=\"note\"");
    }
    return svg_plot(height, label, svg);
}

}  // namespace

std::string look_up_time_plot(const json& report) {
    std::vector<Choice> all = choices(report, "nanoseconds");
    // Half is read as fast as float, for it is float in memory: a bake stored as half is shown by its float.
    const auto ours = std::find_if(all.begin(), all.end(), [](const Choice& choice) { return choice.this_bake; });
    if (ours != all.end()) {
        const Choice bake = *ours;
        for (Choice& choice : all) {
            choice.this_bake = choice.trilinear == bake.trilinear && choice.name == bake.name;
        }
    }
    std::erase_if(all, [](const Choice& choice) { return choice.half; });
    return look_up_plot(all, "nanoseconds for a look-up", "Error against look-up time", false);
}

std::string look_up_bytes_plot(const json& report) {
    return look_up_plot(choices(report, "bytes_per_probe"), "bytes of a probe", "Error against bytes", true);
}

std::string stages_plot(const json& report) {
    std::vector<Bar> rows;
    for (const json& stage : report.at("stages")) {
        const double seconds = stage.at("seconds");
        const double rays = stage.at("rays");
        const std::string rate =
            rays > 0 && seconds > 0 ? fmt::format("{:.2g} Mrays/s", rays * 1e-6 / seconds) : std::string();
        rows.push_back({stage.at("name"), duration_text(seconds), rate, seconds});
    }
    return rows.empty() ? std::string() : svg_plot(bars_height(rows), "Seconds of each stage", bars(rows, 82));
}

}  // namespace lightgrid
