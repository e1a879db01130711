#include "tools/target_options.h"

#include "core/error.h"
#include "probes/gather.h"
#include "tools/light_options.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace lightgrid {
namespace {

constexpr double least_time_budget = 30;  // seconds: less would buy little but start and end

/// A finite number and what follows it, without the spaces between.
std::pair<double, std::string> number_and_unit(const std::string& text) {
    double value = std::nan("");
    const char* end = text.data() + text.size();
    const char* stopped_at = std::from_chars(text.data(), end, value).ptr;
    while (stopped_at != end && *stopped_at == ' ') ++stopped_at;
    return {value, std::string(stopped_at, end)};
}

}  // namespace

double parse_percentage(const std::string& text) {
    const auto [value, unit] = number_and_unit(text);
    if (unit != "%" || !(value > 0 && value <= 100)) {
        throw Error(fmt::format("{} is not a percentage from 0 to 100, such as 2%", text));
    }
    return value / 100;
}

double parse_duration(const std::string& text) {
    static constexpr std::array<std::pair<const char*, double>, 4> units{{{"", 1}, {"s", 1}, {"min", 60}, {"h", 3600}}};
    const auto [value, unit] = number_and_unit(text);
    for (const auto& [name, seconds] : units) {
        if (unit == name && std::isfinite(value)) return value * seconds;
    }
    throw Error(fmt::format("{} is not a duration, such as 60s, 2min or 1h", text));
}

void add_target_options(CLI::App& app, TargetOptions& options) {
    const char* group = "How much (one of three; default: an error of 2% in all but bands)";
    app.add_option("--max-error", options.max_error,
                   "The error of irradiance, relRMSE, that the whole bake may have: finer grids where it takes them, "
                   "more bands, "
                   "more rays")
        ->type_name("P%")
        ->check(checked([](const std::string& text) { static_cast<void>(parse_percentage(text)); }))
        ->group(group);
    app.add_option("--time-budget", options.time_budget,
                   fmt::format("The best that this time buys with 3 bands, load included; {} s and more: 60s, 2min",
                               least_time_budget))
        ->type_name("T")
        ->check(checked([](const std::string& text) {
            if (parse_duration(text) >= least_time_budget) return;
            throw Error(fmt::format("{} is less than {} s", text, least_time_budget));
        }))
        ->group(group);
    app.add_option("--samples", options.samples,
                   fmt::format("Gather rays per probe, all {} replicates together", GatherOptions{}.replicates))
        ->type_name("N")
        ->check(number(1, most_samples, true))
        ->group(group);
    app.add_flag("--strict", options.strict,
                 "Exit status 1 where the error that was asked for is not reached or cannot be judged")
        ->group(group);
}

Target parse_target(const TargetOptions& options) {
    Target target;
    target.samples = options.samples;
    if (!options.max_error.empty()) target.error = parse_percentage(options.max_error);
    if (!options.time_budget.empty()) target.seconds = parse_duration(options.time_budget);
    const int given = int{target.samples.has_value()} + int{target.error.has_value()} + int{target.seconds.has_value()};
    if (given > 1) throw Error("--max-error, --time-budget and --samples exclude each other");
    if (options.strict && (target.samples || target.seconds)) {
        throw Error("--strict needs an error to reach: it excludes --samples and --time-budget");
    }
    return target;
}

}  // namespace lightgrid
