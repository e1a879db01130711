#include "tools/report_page.h"

#include "tools/cost_charts.h"
#include "tools/error_chart.h"
#include "tools/markup.h"
#include "tools/plot.h"
#include "tools/progress.h"
#include "tools/report_style.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

namespace lightgrid {
namespace {

using nlohmann::json;

const PlotColors page_colors{"var(--ink)",  "var(--faint)", "var(--grid)",
                             "var(--card)", "var(--first)", "var(--second)"};

bool is_measured(const json& report) {
    return report["error"]["relrmse"].is_number();
}

std::string interval_text(const json& part) {
    if (part["interval"][0] == part["interval"][1]) return "";  // not measured: there is but one number
    return fmt::format("{} to {}", percent_text(part["interval"][0]), percent_text(part["interval"][1]));
}

/// 12.4 as "12.4", 0.35 as "0.35", 7.5000001 as "7.5".
std::string short_number(double value) {
    return fmt::format("{:.4g}", value);
}

std::string short_triple(const json& v, const char* between, double factor = 1) {
    const auto number = [&](int axis) { return short_number(factor * v[axis].get<double>()); };
    return fmt::format("{}{}{}{}{}", number(0), between, number(1), between, number(2));
}

std::string count_text(double count) {
    return count < 1e5 ? grouped(static_cast<unsigned long long>(count)) : fmt::format("{:.3g} million", 1e-6 * count);
}

// ---- HTML ----------------------------------------------------------------------------------------------------------

std::string element(const std::string& name, const std::string& text) {
    return fmt::format("<{0}>{1}</{0}>\n", name, escape(text));
}

constexpr std::size_t no_column = 99;

struct Table {
    std::vector<std::string> head;
    std::vector<std::vector<std::string>> rows;
    std::size_t first_number = 1;  // columns from here on are numbers
    std::size_t code = no_column;  // what a shell takes
    bool last_is_sum = false;
    bool stacked = false;  // on a phone: a block for each row, each cell behind the name of its column
};

std::string html(const Table& table) {
    const auto cell = [&](const char* tag, std::size_t column, const std::string& text) {
        std::string more = column >= table.first_number ? " class=\"number\"" : "";
        if (table.stacked) more += fmt::format(" data-head=\"{}\"", escape(table.head[column]));
        const bool code = column == table.code && std::string_view(tag) == "td";
        return fmt::format("<{0}{1}>{2}</{0}>", tag, more, code ? "<code>" + escape(text) + "</code>" : escape(text));
    };
    std::string out =
        fmt::format("<div class=\"scroll\"><table{}>\n<thead><tr>", table.stacked ? " class=\"stack\"" : "");
    for (std::size_t i = 0; i < table.head.size(); ++i) out += cell("th", i, table.head[i]);
    out += "</tr></thead>\n<tbody>\n";
    for (const auto& row : table.rows) {
        out += table.last_is_sum && &row == &table.rows.back() ? "<tr class=\"sum\">" : "<tr>";
        for (std::size_t i = 0; i < row.size(); ++i) out += cell("td", i, row[i]);
        out += "</tr>\n";
    }
    return out + "</tbody></table></div>\n";
}

/// A plot, what it says, and the table behind it.
std::string figure(const std::string& title, const std::string& plot, const std::string& caption, const Table& table) {
    return fmt::format(
        "<figure class=\"data\">\n{}{}{}<details><summary>The numbers</summary>\n{}</details>\n</figure>\n",
        element("h3", title), plot, element("figcaption", caption), html(table));
}

std::string tile(const std::string& name, const std::string& value, const std::string& more) {
    return fmt::format("<div class=\"tile\"><small>{}</small><b>{}</b><small>{}</small></div>\n", escape(name),
                       escape(value), escape(more));
}

// ---- sections ------------------------------------------------------------------------------------------------------

double total_seconds(const json& report) {
    double seconds = 0;
    for (const json& stage : report["stages"]) seconds += stage["seconds"].get<double>();
    return seconds;
}

/// The largest part, by name.
std::pair<std::string, const json*> largest_part(const json& error) {
    std::pair<std::string, const json*> largest{"", nullptr};
    for (const auto& [name, part] : error["parts"].items()) {
        if (!part.is_object()) continue;
        if (largest.second == nullptr || part["relrmse"] > (*largest.second)["relrmse"]) largest = {name, &part};
    }
    return largest;
}

std::string probes_text(const json& report) {
    const auto count = [&](const char* name) { return report["probes"][name].get<unsigned long long>(); };
    std::string text = fmt::format("{} gathered", grouped(count("gathered")));
    if (count("moved") > 0) text += fmt::format(", {} of them moved out of solids", grouped(count("moved")));
    if (count("filled") > 0)
        text += fmt::format("; {} inside solids, filled from neighbours", grouped(count("filled")));
    return text;
}

std::string head(const json& report) {
    const json& error = report["error"];
    const std::string level = report["level"];
    std::string out = element("h1", level);
    out += fmt::format("<p class=\"faint\">Light probes baked by Lightgrid {}, {}</p>\n",
                       escape(report["version"].get<std::string>()), escape(report["date"].get<std::string>()));
    const auto [part, value] = largest_part(error);
    if (is_measured(report)) {
        const double total = error["relrmse"];
        out += fmt::format(
            "<p class=\"lead\">Irradiance from this volume is <b>{}</b> off (relative RMSE; 95 % interval {}), "
            "measured "
            "against the path tracer at {} points that no probe knew of.{}</p>\n",
            percent_text(total), interval_text(error), error["points"].get<int>(),
            total > 0 ? fmt::format(" Most of it is <b>{}</b>.", escape(part)) : "");
    } else {
        out += fmt::format("<p class=\"lead\">The error was not measured ({}). Noise at the probes is <b>{}</b>.</p>\n",
                           escape(error["not_measured"].get<std::string>()),
                           percent_text(error["parts"]["noise"]["relrmse"]));
    }
    out += "<div class=\"tiles\">\n";
    if (is_measured(report)) {
        out += tile("Error", percent_text(error["relrmse"]), interval_text(error));
        if (error["target_met"].is_boolean()) {
            out += tile("Target", error["target_met"].get<bool>() ? "met" : "not reached", "");
        }
        out += tile("19 of 20 values are within", percent_text(error["p95"]),
                    fmt::format("of their point's mean; half within {}, 99 of 100 within {}",
                                percent_text(error["p50"]), percent_text(error["p99"])));
    } else {
        const json& noise = error["parts"]["noise"];
        out += tile("Noise at the probes", percent_text(noise["relrmse"]), "standard error of the irradiance");
    }
    const json& rays = report["rays"];
    out += tile("Baked in", duration_text(total_seconds(report)),
                fmt::format("{} rays per probe, {} in all", grouped(report["samples"].get<unsigned>()),
                            count_text(rays["gather"].get<double>() + rays["shadow"].get<double>())));
    out += tile("Volume", bytes_text(report["bytes"]),
                fmt::format("{} probes, {} bands, {}", grouped(report["probes"]["gathered"].get<unsigned long long>()),
                            report["bands"].get<int>(), report["storage"].get<std::string>()));
    return out + "</div>\n";
}

std::string parts_figure(const json& report) {
    const json& error = report["error"];
    Table table{{"part", "relative RMSE", "95 % interval", "square, %²", "share"}, {}};
    const auto share = [&](double square) {
        const double total = error["squares"]["total"];
        return total > 0 ? fmt::format("{:.0f} %", 100 * square / total) : std::string("-");
    };
    for (const auto& [name, part] : error["parts"].items()) {
        if (!part.is_object()) {
            table.rows.push_back({name, "not measured", "", "", ""});
            continue;
        }
        table.rows.push_back({name, percent_text(part["relrmse"]), interval_text(part), "", ""});
        if (!is_measured(report) || !error["squares"].contains(name)) continue;
        const double square = error["squares"][name];
        table.rows.back()[3] = fmt::format("{:.3g}", 1e4 * square);
        table.rows.back()[4] = share(square);
    }
    std::string caption = "Only the noise at the probes is known: what too few samples leave.";
    if (is_measured(report)) {
        const double cross = error["squares"]["cross"];
        table.rows.push_back({"in common (cross terms)", "", "", fmt::format("{:.3g}", 1e4 * cross), share(cross)});
        table.rows.push_back({"total, measured", percent_text(error["relrmse"]), interval_text(error),
                              fmt::format("{:.3g}", 1e4 * error["squares"]["total"].get<double>()), "100 %"});
        table.last_is_sum = true;
        const int bands = report["bands"];
        caption = fmt::format(
            "Noise: too few samples. Bands: what {} coefficients cannot show. Interpolation: what is lost between "
            "probes, light through thin walls included. Storage: rounding to half. Parts add as squares; lines are "
            "95 % intervals.",
            bands * bands);
    }
    if (error["parts"]["bias"].is_null() && report["method"] == "path") {
        caption += " The path tracer has no bias.";
    }
    return figure("What the error is made of", error_parts(report), caption, table);
}

std::string curve_figure(const json& report) {
    const std::string plot = error_curve(report);
    if (plot.empty()) return {};
    Table table{{"seconds", "rays per probe", "million rays", "relative RMSE", "95 % interval"}, {}, 0};
    for (const json& point : report["curve"]) {
        table.rows.push_back({fmt::format("{:.3g}", point["seconds"].get<double>()),
                              grouped(point["samples"].get<unsigned>()),
                              fmt::format("{:.3g}", 1e-6 * point["rays"].get<double>()), percent_text(point["relrmse"]),
                              interval_text(point)});
    }
    return figure("Error against time", svg_plot(error_curve_height, "Error against seconds", plot),
                  "Discs were measured while the samples came in, with their 95 % interval. Dashed: the slope of Monte "
                  "Carlo noise, half for four times the time. Dotted at the right: what more samples would bring.",
                  table);
}

/// What half of the error would cost, in words and as a table of single steps.
std::string remedies(const json& report) {
    const json& halving = report["halving"];
    if (!halving.is_object()) return {};
    std::string out = element("h2", "What less error would cost");
    const std::string target = percent_text(halving["relrmse"]);
    if (halving["seconds"].is_number()) {
        const double factor = halving["samples_factor"];
        out += element("p", fmt::format("Half of the error, {}, would take {:.3g} times the samples: {} of gathering.",
                                        target, factor, duration_text(halving["seconds"])));
    } else {
        out += element("p", fmt::format("Half of the error, {}, is out of reach of samples alone: without any noise {} "
                                        "would be left.",
                                        target, percent_text(halving["floor"])));
    }
    Table table{{"against", "change", "option", "error then", "gathering", "volume", "assumes"}, {}, 7};
    table.code = 2;
    table.stacked = true;
    for (const json& remedy : report["remedies"]) {
        table.rows.push_back({remedy["part"], remedy["change"], remedy["option"], percent_text(remedy["relrmse"]),
                              duration_text(remedy["seconds"]),
                              fmt::format("× {:.2g}", remedy["size_factor"].get<double>()), remedy["assumes"]});
    }
    return out + html(table);
}

std::string look_ups(const json& report) {
    const std::string time = look_up_time_plot(report);
    const std::string bytes = look_up_bytes_plot(report);
    if (time.empty()) return {};
    const auto table = [&](const char* unit, const char* key) {
        Table result{{"", "look-up", "stored as", "relative RMSE", "95 % interval", unit}, {}, 3};
        for (const json& entry : report["look_ups"]) {
            result.rows.push_back(
                {fmt::format("L{}{}", entry["bands"].get<int>() - 1, entry["this_bake"] ? ", this bake" : ""),
                 entry["interpolation"], entry["storage"], percent_text(entry["relrmse"]), interval_text(entry),
                 fmt::format("{:.3g}", entry[key].get<double>())});
        }
        return result;
    };
    return element("h2", "What a look-up costs") + "<div class=\"figures\">\n" +
           figure("Error against look-up time", time,
                  "From position and normal to irradiance on one thread, places spread over the volume. L2 is three "
                  "bands, nine coefficients. The ring is this bake. The line joins what nothing beats in both.",
                  table("ns", "nanoseconds")) +
           figure("Error against memory", bytes,
                  "Coefficients of a probe, in colour. Half takes as long to look up as float: the Sampler holds "
                  "floats.",
                  table("bytes per probe", "bytes_per_probe")) +
           "</div>\n";
}

std::string marker(const Slice& slice, const glm::dvec3& place, std::size_t number, double near,
                   const std::string& title) {
    const glm::dvec2 at = slice.pixel(place);
    const bool away = std::abs(place[slice.axis] - slice.position) > near;
    return fmt::format(
        "<g class=\"{}\">{}<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"11\" class=\"spot\"/><text x=\"{:.1f}\" "
        "y=\"{:.1f}\">{}</text></g>\n",
        away ? "away" : "here", svg_title(title), at.x, at.y, at.x, at.y + 5.3, number);
}

std::string svg_slice(const Slice& slice, const Canvas& picture, const json& worst, double near) {
    constexpr double edge = 12;  // for markers at the volume's faces
    std::string svg = fmt::format(
        "<svg class=\"slice\" viewBox=\"{0} {0} {1} {2}\" role=\"img\" aria-label=\"{3}\" style=\"max-width:{1}px\">\n"
        "<image class=\"mark\" width=\"{4}\" height=\"{5}\" href=\"data:image/png;base64,{6}\"/>\n",
        -edge, picture.width + 2 * edge, picture.height + 2 * edge, escape(slice.title()), picture.width,
        picture.height, base64(picture.png()));
    // The worst on top.
    for (std::size_t i = worst.size(); i-- > 0;) {
        const json& p = worst[i]["position"];
        svg +=
            marker(slice, {p[0], p[1], p[2]}, i + 1, near,
                   fmt::format("{}: {} at {}", i + 1, percent_text(worst[i]["relative_error"]), short_triple(p, ", ")));
    }
    return svg + "</svg>\n";
}

std::string lux_key(const LogScale& lux) {
    constexpr int steps = 64;
    constexpr double thickness = 12;
    std::string svg;
    for (int i = 0; i < steps; ++i) {
        const glm::ivec3 color(glm::round(255.0F * false_color((static_cast<float>(i) + 0.5F) / steps)));
        svg += fmt::format("<rect x=\"{:.2f}\" y=\"0\" width=\"{:.2f}\" height=\"{}\" fill=\"#{:02x}{:02x}{:02x}\"/>\n",
                           12 + (plot_width - 60) * i / steps, (plot_width - 60) / steps + 0.5, thickness, color.r,
                           color.g, color.b);
    }
    const std::size_t every = 1 + (lux.marks.size() - 1) / 10;
    for (std::size_t i = 0; i < lux.marks.size(); i += every) {
        svg += svg_text(12 + (plot_width - 60) * lux.place(lux.marks[i]), thickness + 15,
                        fmt::format("{:g}", lux.marks[i]), "text-anchor=\"middle\"");
    }
    return svg_plot(thickness + 20, "Scale in lux",
                    svg + svg_text(plot_width, thickness + 15, "lux", "text-anchor=\"end\" class=\"axis\""));
}

double half_a_cell(const json& report) {
    double spacing = 0;
    for (const json& grid : report["grids"]) {
        for (const json& s : grid["spacing"]) spacing = std::max(spacing, s.get<double>());
    }
    return 0.5 * spacing;
}

std::string slices_section(const json& report, const SlicePictures& slices) {
    if (slices.slices.empty()) return {};
    const json& error = report["error"];
    const json worst = error.value("worst", json::array());
    std::string out = element("h2", worst.empty() ? "The light" : "The light, and where it is worst");
    std::string text = "Irradiance in the volume, mean over all directions; a contour at every number of the scale.";
    if (!worst.empty()) {
        text +=
            " Numbers mark the held-out points with the largest error; those within half a cell of the plane are "
            "solid, others are seen through it. All slices go through the worst.";
    }
    out += element("p", text) + lux_key(slices.lux) + "<div class=\"figures slices\">\n";
    for (std::size_t i = 0; i < slices.slices.size(); ++i) {
        out += fmt::format("<figure>\n{}{}</figure>\n", element("h3", slices.slices[i].title()),
                           svg_slice(slices.slices[i], slices.pictures[i], worst, half_a_cell(report)));
    }
    out += "</div>\n";
    if (worst.empty()) return out;
    Table table{{"", "x", "y", "z", "relative error"}, {}};
    for (std::size_t i = 0; i < worst.size(); ++i) {
        const json& p = worst[i]["position"];
        const auto place = [&](int axis) { return fmt::format("{:.3f}", p[axis].get<double>()); };
        table.rows.push_back(
            {fmt::format("{}", i + 1), place(0), place(1), place(2), percent_text(worst[i]["relative_error"])});
    }
    return out + fmt::format("<details open><summary>The worst points</summary>\n{}</details>\n", html(table)) +
           fmt::format(
               "<p class=\"faint\">Root mean square over {} normals and three colours, relative to the mean irradiance "
               "at "
               "the point (at least 1 % of the level's median).</p>\n",
               error["normals"].get<int>());
}

std::string stages_section(const json& report) {
    Table table{{"stage", "seconds", "rays", "million rays per second"}, {}};
    for (const json& stage : report["stages"]) {
        const double seconds = stage["seconds"];
        const double rays = stage["rays"];
        table.rows.push_back({stage["name"], fmt::format("{:.3f}", seconds),
                              grouped(stage["rays"].get<unsigned long long>()),
                              rays > 0 && seconds > 0 ? fmt::format("{:.2f}", 1e-6 * rays / seconds) : ""});
    }
    const std::string caption =
        fmt::format("{} in all, on {} threads; {} of memory at most.", duration_text(total_seconds(report)),
                    report["machine"]["threads"].get<int>(), bytes_text(report["machine"]["peak_memory_bytes"]));
    return element("h2", "Where the time went") + "<div class=\"figures\">\n" +
           figure("Seconds of each stage", stages_plot(report), caption, table) + "</div>\n";
}

std::string left_out_section(const json& report) {
    std::string out = element("h2", "What was left out");
    if (report["left_out"].empty()) return out + element("p", "Nothing.");
    Table table{{"what", "why", "saves"}, {}, 3};
    table.stacked = true;
    for (const json& item : report["left_out"]) table.rows.push_back({item["what"], item["evidence"], item["saved"]});
    return out + html(table);
}

std::string settings_section(const json& report) {
    std::string list;
    const auto entry = [&](const std::string& name, const std::string& text) {
        list += fmt::format("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(text));
    };
    const json& scene = report["scene"];
    const double metres_per_unit = scene["metres_per_unit"];
    entry("Level", fmt::format("{}: {} triangles in {} meshes, {} m", report["level"].get<std::string>(),
                               grouped(scene["triangles"].get<unsigned long long>()),
                               grouped(scene["meshes"].get<unsigned long long>()),
                               short_triple(scene["size"], " x ", metres_per_unit)));
    entry("Light",
          fmt::format("{}; {} punctual lights and all emissive surfaces of the level",
                      report["environment"] == "none" ? "no environment" : report["environment"].get<std::string>(),
                      scene["punctual_lights"].get<int>()));
    for (const json& grid : report["grids"]) {
        entry("Grid",
              fmt::format("{} probes, {} m apart, from {}", short_triple(grid["counts"], " x "),
                          short_triple(grid["spacing"], " x ", metres_per_unit), short_triple(grid["origin"], ", ")));
    }
    entry("Spacing", report["spacing"]);
    entry("Probes", probes_text(report));
    entry("Samples", fmt::format("{} per probe in {} replicates: {}", grouped(report["samples"].get<unsigned>()),
                                 report["replicates"].get<int>(), report["why_samples"].get<std::string>()));
    entry("Bands", fmt::format("{}, stored as {}", report["bands"].get<int>(), report["storage"].get<std::string>()));
    for (const json& layer : report["layers"]) {
        entry("Layer", fmt::format("{}: {}, noise {}", layer["name"].get<std::string>(), bytes_text(layer["bytes"]),
                                   percent_text(layer["noise"])));
    }
    entry("Method", report["method"]);
    entry("Seed", fmt::format("{}", report["seed"].get<std::uint64_t>()));
    entry("File", fmt::format("{}, {}", report["output"].get<std::string>(), bytes_text(report["bytes"])));
    const json& machine = report["machine"];
    entry("Machine", fmt::format("{}, {} logical processors, {}", machine["processor"].get<std::string>(),
                                 machine["logical_processors"].get<int>(), bytes_text(machine["memory_bytes"])));
    entry("System", machine["system"]);
    entry("Built with",
          fmt::format("{}; {}", machine["built_with"].get<std::string>(), machine["libraries"].get<std::string>()));
    return element("h2", "How it was baked") +
           fmt::format("<p><code>{}</code></p>\n<dl>\n{}</dl>\n", escape(report["command"].get<std::string>()), list);
}

}  // namespace

glm::dvec3 slice_point(const json& report, const Volume& volume) {
    const json worst = report.at("error").value("worst", json::array());
    if (!worst.empty()) {
        const json& p = worst[0].at("position");
        return {p.at(0), p.at(1), p.at(2)};
    }
    const Box box = bounds_of(volume);
    return box.min + glm::dvec3(0.5, 0.4, 0.5) * box.size();
}

std::string report_page(const json& report, const std::optional<SlicePictures>& slices) {
    std::string page = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
        "'unsafe-inline'\">\n<link rel=\"icon\" href=\"data:,\">\n<title>{}: light probes</title>\n"
        "<style>\n{}{}</style>\n</head>\n<body>\n",
        escape(report["level"].get<std::string>()), report_style(), plot_style(page_colors));
    page += head(report);
    page += element("h2", "How wrong it is") + "<div class=\"figures\">\n" + parts_figure(report) +
            curve_figure(report) + "</div>\n";
    page += remedies(report);
    if (slices) page += slices_section(report, *slices);
    page += look_ups(report) + stages_section(report) + left_out_section(report) + settings_section(report);
    return page + "</body>\n</html>\n";
}

}  // namespace lightgrid
