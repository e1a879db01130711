#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>

/// What light costs, as plots from a bake's report: svg elements, empty where the report has no such numbers.
namespace lightgrid {

/// Error against the time of a look-up, and against the bytes of a probe, for every way to keep and read the volume;
/// those that nothing beats in both are joined by a line.
[[nodiscard]] std::string look_up_time_plot(const nlohmann::json& report);
[[nodiscard]] std::string look_up_bytes_plot(const nlohmann::json& report);

/// Seconds and rays per second of every stage.
[[nodiscard]] std::string stages_plot(const nlohmann::json& report);

}  // namespace lightgrid
