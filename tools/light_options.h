#pragma once

#include "core/environment.h"

#include <CLI/CLI.hpp>

#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace lightgrid {

/// The light that a program adds to the level's own: the options that level-bake and `lightgrid reference` share.
struct LightOptions {
    std::string environment;
    std::string layout = "auto";
    std::string layer;
    double rotation_deg = 0;
    double intensity = 1;
    std::string sky;
    std::string sun_sky;
};

void add_light_options(CLI::App& app, LightOptions& options);

struct ChosenLight {
    Environment environment;
    std::string description;           // one line, with file names but no folders
    std::vector<std::string> notices;  // what was assumed
};

/// Throws Error for values that make no sense and for files that cannot be read.
[[nodiscard]] ChosenLight choose_light(const LightOptions& options);

/// "1,2,3" as numbers; throws Error unless there are `count` finite ones.
[[nodiscard]] std::vector<double> parse_numbers(const std::string& text, std::size_t count, const std::string& example);

/// Refuses what `parse` throws Error for, so that every wrong value of a call is reported at once.
[[nodiscard]] CLI::Validator checked(const std::function<void(const std::string&)>& parse);
/// Refuses what is no finite number from `least` to `most`.
[[nodiscard]] CLI::Validator number(double least = std::numeric_limits<double>::lowest(),
                                    double most = std::numeric_limits<double>::max(), bool whole = false);

}  // namespace lightgrid
