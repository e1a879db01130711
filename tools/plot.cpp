#include "tools/plot.h"

#include "tools/markup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

namespace lightgrid {
namespace {

constexpr double bar_row = 30;
constexpr double bar_thickness = 14;
constexpr double bar_names = 92;
constexpr double bar_values = 60;
constexpr std::size_t few_marks = 4;
constexpr std::size_t many_marks = 7;

}  // namespace

std::string plot_style(const PlotColors& colors) {
    return fmt::format(
        ".plot text{{fill:{ink};font-size:12px}} .plot .note{{fill:{faint};font-size:11px}} "
        ".plot .axis{{font-weight:600}} .plot .value{{font-weight:600}}\n"
        ".plot .grid{{stroke:{grid}}} .plot .slope{{stroke:{faint};stroke-dasharray:6 5;fill:none}} "
        ".plot .floor{{stroke:{second};stroke-width:1.5;stroke-dasharray:2 4}} .plot .floor-note{{fill:{second}}}\n"
        ".plot .band{{fill:{first};opacity:.18}} .plot .curve{{fill:none;stroke:{first};stroke-width:2.5}} "
        ".plot .predicted{{fill:none;stroke:{first};stroke-width:2;stroke-dasharray:1 5;stroke-linecap:round}}\n"
        ".plot .front{{fill:none;stroke:{grid};stroke-width:2}} .plot .whisker{{stroke:{ink};stroke-width:1.5}} "
        ".plot .this{{fill:none;stroke:{ink};stroke-width:1.5}}\n"
        ".plot .first{{fill:{first};stroke:{first};stroke-width:2}} "
        ".plot .second{{fill:{second};stroke:{second};stroke-width:2}} .plot .hollow{{fill:{paper}}} "
        ".plot .bar{{stroke:none}}\n",
        fmt::arg("ink", colors.ink), fmt::arg("faint", colors.faint), fmt::arg("grid", colors.grid),
        fmt::arg("paper", colors.paper), fmt::arg("first", colors.first), fmt::arg("second", colors.second));
}

double Axis::place(double value) const {
    return start + (end - start) * std::log(std::clamp(value, first, last) / first) / std::log(last / first);
}

std::vector<double> Axis::marks() const {
    const auto within = [&](std::initializer_list<double> steps) {
        std::vector<double> all;
        for (double decade = std::pow(10, std::floor(std::log10(first))); decade <= last; decade *= 10) {
            for (const double step : steps) {
                if (step * decade >= first && step * decade <= last) all.push_back(step * decade);
            }
        }
        return all;
    };
    for (const auto& steps : {std::initializer_list<double>{1}, {1, 3}, {1, 2, 5}, {1, 1.5, 2, 3, 4, 5, 6, 8}}) {
        std::vector<double> marks = within(steps);
        if (marks.size() >= few_marks && marks.size() <= many_marks) return marks;
    }
    std::vector<double> marks = within({1, 1.5, 2, 3, 4, 5, 6, 8});
    if (marks.size() > many_marks) marks = within({1});
    if (marks.size() < 2) marks = {first, last};
    return marks;
}

Axis axis_around(const std::vector<double>& values, double start, double end) {
    constexpr double room = 1.25;
    double low = std::numeric_limits<double>::infinity();
    double high = 0;
    for (const double value : values) {
        if (!(value > 0) || !std::isfinite(value)) continue;
        low = std::min(low, value);
        high = std::max(high, value);
    }
    if (high == 0) return {1, 10, start, end};
    return {low / room, high * room, start, end};
}

std::string svg_text(double x, double y, std::string_view what, std::string_view more) {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" {}>{}</text>\n", x, y, more, escape(what));
}

std::string svg_line(double x0, double y0, double x1, double y1, std::string_view more) {
    return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n", x0, y0, x1, y1, more);
}

std::string svg_title(std::string_view what) {
    return fmt::format("<title>{}</title>", escape(what));
}

std::string plot_frame(const Axis& x, const Axis& y, std::string_view x_name, std::string_view y_name, bool y_percent) {
    const double bottom = y.start;
    const double top = y.end;
    std::string svg;
    for (const double value : x.marks()) {
        svg += svg_line(x.place(value), top, x.place(value), bottom, "class=\"grid\"");
        svg += svg_text(x.place(value), bottom + 17, fmt::format("{:.3g}", value), "text-anchor=\"middle\"");
    }
    for (const double value : y.marks()) {
        svg += svg_line(x.start, y.place(value), x.end, y.place(value), "class=\"grid\"");
        svg += svg_text(x.start - 6, y.place(value) + 4, y_percent ? percent_text(value) : fmt::format("{:.3g}", value),
                        "text-anchor=\"end\"");
    }
    svg += svg_text(x.end, bottom + 36, x_name, "text-anchor=\"end\" class=\"axis\"");
    svg += svg_text(2, top - 10, y_name, "class=\"axis\"");
    return svg;
}

std::string bars(const std::vector<Bar>& rows, double note_width) {
    const double values_end = plot_width - note_width;
    const double end = values_end - bar_values;
    double largest = 0;
    for (const Bar& row : rows) largest = std::max({largest, row.value, row.high});
    const auto place = [&](double value) {
        return largest > 0 ? bar_names + (end - bar_names) * std::max(value, 0.0) / largest : bar_names;
    };
    std::string svg;
    double middle = 0.5 * bar_row;
    for (const Bar& row : rows) {
        svg += svg_text(bar_names - 8, middle + 4, row.name,
                        row.emphasis ? "text-anchor=\"end\" class=\"value\"" : "text-anchor=\"end\"");
        svg += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{}\" class=\"mark bar {}\"/>\n",
                           bar_names, middle - 0.5 * bar_thickness, std::max(place(row.value) - bar_names, 1.0),
                           bar_thickness, row.emphasis ? "first" : "second");
        if (row.high > row.low) {
            svg += svg_line(place(row.low), middle, place(row.high), middle, "class=\"whisker\"");
            for (const double at : {place(row.low), place(row.high)}) {
                svg += svg_line(at, middle - 4, at, middle + 4, "class=\"whisker\"");
            }
        }
        svg += svg_text(values_end, middle + 4, row.value_text, "text-anchor=\"end\" class=\"value\"");
        if (!row.note.empty()) {
            svg += svg_text(plot_width, middle + 4, row.note, "text-anchor=\"end\" class=\"note\"");
        }
        middle += bar_row;
    }
    return svg;
}

double bars_height(const std::vector<Bar>& rows) {
    return bar_row * static_cast<double>(rows.size());
}

std::string svg_plot(double height, std::string_view label, std::string_view content) {
    return fmt::format(
        "<svg class=\"plot\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\" "
        "aria-label=\"{2}\">\n{3}</svg>\n",
        plot_width, height, escape(label), content);
}

}  // namespace lightgrid
