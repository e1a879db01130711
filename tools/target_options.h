#pragma once

#include "probes/target.h"

#include <cstdint>
#include <optional>
#include <string>

namespace CLI {  // NOLINT(readability-identifier-naming)
class App;
}

/// What a bake is to reach or may cost, on the command line.
namespace lightgrid {

/// --samples takes no more: their directions take 3 GB per thread and 16 replicates.
inline constexpr double most_samples = 1U << 28;

/// As they were typed; empty: not given.
struct TargetOptions {
    std::optional<std::uint32_t> samples;
    std::string max_error;
    std::string time_budget;
    bool strict = false;
};

void add_target_options(CLI::App& app, TargetOptions& options);

/// Throws Error where more than one is given, or --strict without a target that can be missed.
[[nodiscard]] Target parse_target(const TargetOptions& options);

/// "2%" as 0.02. Throws Error for what is no percentage, or not between 0 and 100.
[[nodiscard]] double parse_percentage(const std::string& text);
/// "60s", "90", "2min", "1.5h" as seconds. Throws Error for what is no duration.
[[nodiscard]] double parse_duration(const std::string& text);

}  // namespace lightgrid
