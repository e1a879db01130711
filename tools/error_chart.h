#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>

/// The error of a bake as plots, from its report (level-bake --report-json).
namespace lightgrid {

/// Error against seconds on logarithmic axes: what was measured with its 95 % interval, the slope of Monte Carlo noise,
/// what is left however many samples there are, and what more of them would bring. The content of an svg element,
/// plot_width x error_curve_height; empty where the report holds no error above zero.
inline constexpr double error_curve_height = 300;
[[nodiscard]] std::string error_curve(const nlohmann::json& report);

/// A bar for the total and for each part that was measured, largest first, with 95 % intervals. An svg element.
[[nodiscard]] std::string error_parts(const nlohmann::json& report);

/// Both beside each other as a picture of its own. Throws Error where the report holds no measured error.
///
/// where  what messages call the report
[[nodiscard]] std::string error_chart(const nlohmann::json& report, const std::string& where);

}  // namespace lightgrid
