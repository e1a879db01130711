#include "tools/report_page.h"

#include "tools/cost_charts.h"
#include "tools/error_chart.h"
#include "tools/markup.h"
#include "tools/plot.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>

namespace lightgrid {
namespace {

using nlohmann::json;

constexpr const char* hostile = "</title><script>alert('\"&')</script>";

std::size_t count(const std::string& text, const std::string& what) {
    std::size_t found = 0;
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += what.size()) ++found;
    return found;
}

json part(double relrmse) {
    return {{"relrmse", relrmse}, {"interval", {0.9 * relrmse, 1.1 * relrmse}}};
}

/// A measured bake of 2 % error, half of whose square is noise; every text is `text`.
json report_of(const std::string& text) {
    json report{{"version", text}, {"command", text},   {"date", text},     {"level", text},   {"environment", text},
                {"output", text},  {"storage", "half"}, {"method", "path"}, {"spacing", text}, {"why_samples", text},
                {"bytes", 163840}, {"bands", 3},        {"seed", 7},        {"samples", 256},  {"replicates", 16}};
    report["machine"] = {{"processor", text}, {"logical_processors", 2},     {"memory_bytes", 1 << 30},
                         {"system", text},    {"built_with", text},          {"libraries", text},
                         {"threads", 2},      {"peak_memory_bytes", 1 << 20}};
    report["scene"] = {{"triangles", 12},      {"meshes", 1},       {"materials", 1},
                       {"punctual_lights", 0}, {"size", {1, 2, 3}}, {"metres_per_unit", 1}};
    report["grids"] = {{{"origin", {0, 0, 0}}, {"spacing", {1, 1, 1}}, {"counts", {2, 3, 4}}}};
    report["probes"] = {{"gathered", 24}, {"valid", 20}, {"moved", 4}, {"invalid", 0}, {"filled", 0}};
    report["error"] = part(0.02);
    report["error"].update(
        {{"target_met", nullptr}, {"points", 32}, {"normals", 64}, {"p50", 0.01}, {"p95", 0.04}, {"p99", 0.08}});
    report["error"]["parts"] = {{"noise", part(0.015)},
                                {"bands", part(0.01)},
                                {"interpolation", part(0.009)},
                                {"bias", nullptr},
                                {"storage", part(0.0001)}};
    report["error"]["squares"] = {{"noise", 2.25e-4}, {"bands", 1e-4},  {"interpolation", 0.81e-4},
                                  {"storage", 1e-8},  {"cross", -6e-6}, {"total", 4e-4}};
    report["error"]["worst"] = {{{"position", {0.25, 0.5, 0.75}}, {"relative_error", 0.3}},
                                {{"position", {0.5, 1.5, 2.5}}, {"relative_error", 0.2}}};
    for (int i = 1; i <= 4; ++i) {
        report["curve"].push_back(part(0.05 / i));
        report["curve"].back().update({{"seconds", i}, {"samples", 64 * i}, {"rays", 1000 * i}});
    }
    report["halving"] = {{"relrmse", 0.01}, {"floor", 0.0132}, {"samples_factor", nullptr}, {"seconds", nullptr}};
    report["remedies"] = {{{"part", "noise"},
                           {"change", text},
                           {"option", text},
                           {"relrmse", 0.015},
                           {"assumes", text},
                           {"seconds", 16},
                           {"size_factor", 1}}};
    for (const char* interpolation : {"trilinear", "nearest"}) {
        for (const char* storage : {"float", "half"}) {
            for (int bands = 1; bands <= 3; ++bands) {
                json entry = part(0.06 / bands);
                entry.update({{"interpolation", interpolation},
                              {"storage", storage},
                              {"bands", bands},
                              {"nanoseconds", 30 + bands},
                              {"bytes_per_probe", 12 * bands * bands},
                              {"this_bake", bands == 3 && std::string(storage) == "half" &&
                                                std::string(interpolation) == "trilinear"}});
                report["look_ups"].push_back(entry);
            }
        }
    }
    report["layers"] = {{{"name", text}, {"bytes", 1000}, {"noise", 0.02}}};
    report["left_out"] = {{{"what", text}, {"evidence", text}, {"saved", text}}};
    report["stages"] = {{{"name", text}, {"seconds", 0.5}, {"rays", 0}},
                        {{"name", "gather"}, {"seconds", 4}, {"rays", 4000}}};
    report["rays"] = {{"gather", 3000}, {"shadow", 1000}, {"dropped", 0}};
    return report;
}

json unmeasured_report() {
    json report = report_of("text");
    report["error"] = {{"relrmse", nullptr},
                       {"interval", nullptr},
                       {"target_met", nullptr},
                       {"not_measured", "a list <has> no cells"},
                       {"parts",
                        {{"noise", part(0.01)},
                         {"bands", nullptr},
                         {"interpolation", nullptr},
                         {"bias", nullptr},
                         {"storage", nullptr}}}};
    report["halving"] = nullptr;
    for (const char* empty : {"curve", "look_ups", "remedies", "grids", "layers", "left_out"})
        report[empty] = json::array();
    return report;
}

/// Two slices of a volume of 1 m x 2 m x 3 m.
SlicePictures slices() {
    Box box;
    box.extend({0, 0, 0});
    box.extend({1, 2, 3});
    SlicePictures pictures;
    for (const int axis : {1, 0}) {
        pictures.slices.push_back({axis, 0.5, box, 10});
        const glm::ivec2 size = pictures.slices.back().size();
        pictures.pictures.emplace_back(size.x, size.y, glm::vec3(0.5F));
    }
    pictures.lux.marks = {1, 2, 5, 10};
    return pictures;
}

TEST(Markup, EscapesWhatMarkupIsMadeOf) {
    EXPECT_EQ(escape("<a href=\"x\">'&'</a>"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
}

TEST(Markup, Base64AsInTheStandard) {  // RFC 4648, section 10
    EXPECT_EQ(base64(""), "");
    EXPECT_EQ(base64("f"), "Zg==");
    EXPECT_EQ(base64("fo"), "Zm8=");
    EXPECT_EQ(base64("foo"), "Zm9v");
    EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
    EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
}

TEST(Markup, NumbersAsPeopleReadThem) {
    EXPECT_EQ(percent_text(0.0421), "4.21 %");
    EXPECT_EQ(percent_text(0), "0 %");
    EXPECT_EQ(percent_text(1e-9), "< 0.001 %");
    EXPECT_EQ(percent_text(17.38), "1738 %");
    EXPECT_EQ(percent_text(-0.02), "0 %") << "an estimate of a square that is below 0";
    EXPECT_EQ(grouped(7), "7");
    EXPECT_EQ(grouped(1000), "1,000");
    EXPECT_EQ(grouped(65536), "65,536");
}

TEST(Plot, AxesHaveAFewRoundMarks) {
    for (const double first : {1e-6, 0.03, 0.7, 9.5, 1e4}) {
        for (const double ratio : {1.6, 3.0, 20.0, 1e3, 1e7}) {
            const Axis axis{first, first * ratio, 0, 100};
            const std::vector<double> marks = axis.marks();
            EXPECT_GE(marks.size(), 2U) << first << " " << ratio;
            EXPECT_LE(marks.size(), 9U) << first << " " << ratio;
            EXPECT_TRUE(std::is_sorted(marks.begin(), marks.end()));
            for (const double mark : marks) {
                EXPECT_GE(mark, first * (1 - 1e-12));
                EXPECT_LE(mark, first * ratio * (1 + 1e-12));
            }
        }
    }
}

TEST(Plot, AxesHoldTheirValues) {
    const Axis axis = axis_around({0.2, -1, 0, 0.05, 3}, 10, 20);
    EXPECT_LT(axis.first, 0.05);
    EXPECT_GT(axis.last, 3);
    EXPECT_EQ(axis.place(axis.first), 10);
    EXPECT_EQ(axis.place(axis.last), 20);
    EXPECT_EQ(axis_around({}, 0, 1).first, 1) << "nothing to hold";
}

TEST(ReportPage, EscapesEveryText) {
    const std::string page = report_page(report_of(hostile), slices());
    EXPECT_EQ(page.find("<script"), std::string::npos);
    EXPECT_EQ(count(page, "</title>"), count(page, "<title>"));
    EXPECT_GT(count(page, "&lt;script&gt;alert(&#39;&quot;&amp;&#39;)"), 15U);
}

TEST(ReportPage, RefersToNothingOutside) {
    const std::string page = report_page(report_of("text"), slices());
    EXPECT_EQ(page.find("://"), std::string::npos);
    EXPECT_EQ(page.find("url("), std::string::npos);
    EXPECT_EQ(page.find("@import"), std::string::npos);
    EXPECT_EQ(count(page, "href=\"") + count(page, "src=\""), count(page, "href=\"data:"));
    EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

TEST(ReportPage, EveryPlotHasItsDataAndItsTable) {
    const json report = report_of("text");
    EXPECT_EQ(count(error_parts(report), "\"mark "), 5U) << "the total and four measured parts";
    EXPECT_EQ(count(error_curve(report), "\"mark "), 4U);
    EXPECT_EQ(count(look_up_time_plot(report), "\"mark "), 6U) << "float only: half is read as float";
    EXPECT_EQ(count(look_up_bytes_plot(report), "\"mark "), 12U);
    EXPECT_EQ(count(stages_plot(report), "\"mark "), 2U);
    for (const char* plot : {"class=\"this\"", "L0", "L1", "L2"}) {
        EXPECT_NE(look_up_time_plot(report).find(plot), std::string::npos) << plot;
        EXPECT_NE(look_up_bytes_plot(report).find(plot), std::string::npos) << plot;
    }
    const std::string page = report_page(report, slices());
    EXPECT_EQ(count(page, "<figure class=\"data\">"), 5U);
    EXPECT_EQ(count(page, "<details><summary>The numbers"), 5U);
    EXPECT_EQ(count(page, "<svg class=\"slice\""), 2U);
    EXPECT_EQ(count(page, "data:image/png;base64,iVBORw0KGgo"), 2U);
}

TEST(ReportPage, MarksTheWorstPointsWhereTheyAre) {
    const std::string page = report_page(report_of("text"), slices());
    // 10 pixels per metre. In the plan at y = 0.5 the first point is (0.25, 0.75): in the plane; the second is 1 m above.
    EXPECT_NE(page.find("<g class=\"here\"><title>1: 30 % at 0.25, 0.5, 0.75</title><circle cx=\"2.5\" cy=\"7.5\""),
              std::string::npos);
    EXPECT_NE(page.find("<g class=\"away\"><title>2: 20 % at 0.5, 1.5, 2.5</title><circle cx=\"5.0\" cy=\"25.0\""),
              std::string::npos);
    const Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {2, 3, 4}}}, 1);
    EXPECT_EQ(slice_point(report_of("text"), volume), glm::dvec3(0.25, 0.5, 0.75));
    EXPECT_EQ(slice_point(unmeasured_report(), volume), glm::dvec3(0.5, 0.8, 1.5));
}

TEST(ReportPage, SaysWhatHalfOfTheErrorCosts) {
    json report = report_of("text");
    EXPECT_NE(report_page(report, {}).find("Half of the error, 1 %, is out of reach of samples alone"),
              std::string::npos);
    report["halving"].update({{"samples_factor", 6}, {"seconds", 24}});
    EXPECT_NE(report_page(report, {}).find("Half of the error, 1 %, would take 6 times the samples: 24 s"),
              std::string::npos);
}

TEST(ReportPage, SaysWhyWhereNothingWasMeasured) {
    const std::string page = report_page(unmeasured_report(), {});
    EXPECT_NE(page.find("not measured (a list &lt;has&gt; no cells)"), std::string::npos);
    EXPECT_EQ(count(page, "<figure class=\"data\">"), 2U) << "noise and stages";
    EXPECT_EQ(page.find("slice\""), std::string::npos);
}

TEST(ReportPage, HasNoPlotOfErrorsThatHaveNoLogarithm) {
    json report = report_of("text");
    for (json& point : report["curve"]) point["relrmse"] = 0;
    for (json& look_up : report["look_ups"]) look_up["relrmse"] = -1e-9;
    report["error"]["relrmse"] = 0;
    report["error"]["squares"]["total"] = 0;
    report["halving"] = nullptr;
    const std::string page = report_page(report, {});
    EXPECT_EQ(count(page, "<figure class=\"data\">"), 2U) << "parts and stages";
    EXPECT_EQ(page.find("nan"), std::string::npos);
    EXPECT_EQ(page.find("inf"), std::string::npos);
}

}  // namespace
}  // namespace lightgrid
