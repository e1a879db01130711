#pragma once

#include <string>
#include <string_view>
#include <vector>

/// Plots as SVG text. Lengths are SVG user units; a plot is plot_width wide, its letters 12 high, so that it reads at the
/// width of a phone. Colours come from classes: plot_style has their rules.
namespace lightgrid {

inline constexpr double plot_width = 400;

/// CSS colours, as values or as var(...).
struct PlotColors {
    std::string ink, faint, grid, paper, first, second;
};
/// Rules for all classes that plots use; `mark` are those that stand for data.
[[nodiscard]] std::string plot_style(const PlotColors& colors);

/// From `first` to `last`, drawn from `start` to `end`.
struct Axis {
    double first = 1;
    double last = 10;
    double start = 0;
    double end = 1;

    /// On the logarithmic scale; what is beyond the axis is at its end.
    [[nodiscard]] double place(double value) const;
    /// Round numbers within the axis: 1, 2 and 5 times powers of ten, more where these are few, fewer where many.
    [[nodiscard]] std::vector<double> marks() const;
};

/// A logarithmic axis that holds all of `values` with some room around them; those that have no logarithm do not count.
[[nodiscard]] Axis axis_around(const std::vector<double>& values, double start, double end);

/// `what` is escaped; `more` are attributes.
[[nodiscard]] std::string svg_text(double x, double y, std::string_view what, std::string_view more = {});
[[nodiscard]] std::string svg_line(double x0, double y0, double x1, double y1, std::string_view more);
/// What a pointer that rests on the element reads.
[[nodiscard]] std::string svg_title(std::string_view what);

/// Lines and numbers at the marks of both axes, and what the axes mean. The upper end of `y` is the plot's top.
[[nodiscard]] std::string plot_frame(const Axis& x, const Axis& y, std::string_view x_name, std::string_view y_name,
                                     bool y_percent);

/// A row of a bar chart. Numbers below 0 count as 0.
struct Bar {
    std::string name;
    std::string value_text;
    std::string note;  // right of the value, faint
    double value = 0;
    double low = 0;  // an interval is drawn where high > low
    double high = 0;
    bool emphasis = false;
};
/// Horizontal bars on a linear scale. note_width: room for the notes at the right.
[[nodiscard]] std::string bars(const std::vector<Bar>& rows, double note_width);
[[nodiscard]] double bars_height(const std::vector<Bar>& rows);

/// The svg element around a plot, for a page.
[[nodiscard]] std::string svg_plot(double height, std::string_view label, std::string_view content);

}  // namespace lightgrid
