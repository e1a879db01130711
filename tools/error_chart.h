#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace lightgrid {

/// The curve of a bake's report (level-bake --report-json) as an SVG picture: error against seconds on logarithmic axes
/// with its 95 % band, the slope of Monte Carlo noise, and beside it the parts that the final error is made of.
/// Throws Error where the report holds no measured error.
///
/// where  what messages call the report
[[nodiscard]] std::string error_chart(const nlohmann::json& report, const std::string& where);

}  // namespace lightgrid
