#include "tools/level_options.h"

#include "core/error.h"
#include "tools/light_options.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <limits>

namespace lightgrid {
namespace {

// Names of settings.
constexpr const char* scene_setting = "scene";
constexpr const char* ignore_setting = "ignore";

/// Reads a setting into `value` where it is there and `value` was not given. Settings are written as JSON.
template <typename T>
void read(const Volume& volume, const char* name, std::optional<T>& value) {
    const auto found = volume.settings.find(name);
    if (value || found == volume.settings.end()) return;
    try {
        value = nlohmann::json::parse(found->second).get<T>();
    } catch (const nlohmann::json::exception&) {
        throw Error(fmt::format("\"{}\" does not read as level-bake writes it", found->second),
                    fmt::format("the volume's setting \"{}\"", name), "Bake the volume anew.");
    }
}

}  // namespace

void add_level_options(CLI::App& app, LevelOptions& options) {
    const char* group = "Level";
    app.add_option("--scene", options.scene, "Which of the file's scenes (default: the file's own choice)")
        ->type_name("N")
        ->check(number(0, std::numeric_limits<int>::max(), true))
        ->group(group);
    app.add_option_function<std::vector<std::string>>(
           "--ignore", [&options](const std::vector<std::string>& patterns) { options.ignore = patterns; },
           "Leaves out nodes of this name, with all below them: of their mesh's where they have none; * fits any "
           "letters. May be repeated")
        ->type_name("NAME")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->allow_extra_args(false)
        ->group(group);
}

std::vector<std::string> names_of(const LevelOptions& options) {
    std::vector<std::string> names;
    if (options.scene) names.emplace_back("--scene");
    if (options.ignore) names.emplace_back("--ignore");
    return names;
}

LoadOptions load_options(const LevelOptions& options) {
    LoadOptions load;
    load.scene = options.scene.value_or(load.scene);
    for (const std::string& pattern : options.ignore.value_or(std::vector<std::string>{}))
        if (!pattern.empty()) load.ignore.push_back(pattern);
    return load;
}

void record(const LevelOptions& options, Volume& volume) {
    if (options.scene) volume.settings[scene_setting] = nlohmann::json(*options.scene).dump();
    if (options.ignore) volume.settings[ignore_setting] = nlohmann::json(*options.ignore).dump();
}

LevelOptions with_recorded(LevelOptions given, const Volume& volume) {
    read(volume, scene_setting, given.scene);
    read(volume, ignore_setting, given.ignore);
    return given;
}

}  // namespace lightgrid
