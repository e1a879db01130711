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
constexpr const char* default_albedo_setting = "default_albedo";
constexpr const char* missing_textures_setting = "missing_textures";
constexpr const char* scale_setting = "scale";

constexpr double least_scale = 1e-6;
constexpr double most_scale = 1e6;

template <typename T>
bool is_any(const T&) {
    return true;
}

bool is_scene(const int& index) {
    return index >= 0;
}

bool is_albedo(const double& albedo) {
    return albedo >= 0 && albedo <= 1;
}

bool is_scale(const double& scale) {
    return scale >= least_scale && scale <= most_scale;
}

std::optional<MissingTextures> missing_textures_of(const std::string& name) {
    if (name == "warn") return MissingTextures::warn;
    if (name == "error") return MissingTextures::error;
    return {};
}

bool is_missing_textures(const std::string& name) {
    return missing_textures_of(name).has_value();
}

/// Reads a setting into `value` where it is there and `value` was not given. Settings are written as JSON.
template <typename T>
void read(const Volume& volume, const char* name, std::optional<T>& value, bool (&is_valid)(const T&) = is_any<T>) {
    const auto found = volume.settings.find(name);
    if (value || found == volume.settings.end()) return;
    try {
        value = nlohmann::json::parse(found->second).get<T>();
    } catch (const nlohmann::json::exception&) {
    }
    if (!value || !is_valid(*value)) {
        throw Error(fmt::format("\"{}\" does not read as level-bake writes it", found->second),
                    fmt::format("the volume's setting \"{}\"", name), "Bake the volume anew.");
    }
}

MissingTextures parse_missing_textures(const std::string& name) {
    const std::optional<MissingTextures> known = missing_textures_of(name);
    if (!known) throw Error(fmt::format("{} is not known: there are warn and error", name));
    return *known;
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
    app.add_option("--default-albedo", options.default_albedo,
                   fmt::format("Albedo of a level in which no primitive has a material (default: {:g})",
                               LoadOptions{}.default_albedo))
        ->type_name("A")
        ->check(number(0, 1))
        ->group(group);
    app.add_option(
           "--missing-textures", options.missing_textures,
           "warn: textures that cannot be read are named and left out, and no error is judged; error: the level "
           "is refused (default: warn)")
        ->type_name("NAME")
        ->check(checked([](const std::string& name) { static_cast<void>(parse_missing_textures(name)); }))
        ->group(group);
    app.add_option(
           "--scale", options.scale,
           "Metres in a unit of the level's file: 0.01 where it is in centimetres. Changes what is told or chosen "
           "in metres; coordinates and light stay the file's (default: 1)")
        ->type_name("S")
        ->check(number(least_scale, most_scale))
        ->group(group);
}

std::vector<std::string> names_of(const LevelOptions& options) {
    std::vector<std::string> names;
    if (options.scene) names.emplace_back("--scene");
    if (options.ignore) names.emplace_back("--ignore");
    if (options.default_albedo) names.emplace_back("--default-albedo");
    if (options.missing_textures) names.emplace_back("--missing-textures");
    if (options.scale) names.emplace_back("--scale");
    return names;
}

LoadOptions load_options(const LevelOptions& options) {
    LoadOptions load;
    load.scene = options.scene.value_or(load.scene);
    for (const std::string& pattern : options.ignore.value_or(std::vector<std::string>{}))
        if (!pattern.empty()) load.ignore.push_back(pattern);
    if (options.default_albedo) load.default_albedo = static_cast<float>(*options.default_albedo);
    if (options.missing_textures) load.missing_textures = parse_missing_textures(*options.missing_textures);
    if (options.scale) load.metres_per_unit = *options.scale;
    return load;
}

double metres_per_unit(const Volume& volume) {
    std::optional<double> scale;
    read(volume, scale_setting, scale, is_scale);
    return scale.value_or(LoadOptions{}.metres_per_unit);
}

void record(const LevelOptions& options, Volume& volume) {
    if (options.scene) volume.settings[scene_setting] = nlohmann::json(*options.scene).dump();
    if (options.ignore) volume.settings[ignore_setting] = nlohmann::json(*options.ignore).dump();
    if (options.default_albedo)
        volume.settings[default_albedo_setting] = nlohmann::json(*options.default_albedo).dump();
    if (options.missing_textures)
        volume.settings[missing_textures_setting] = nlohmann::json(*options.missing_textures).dump();
    if (options.scale) volume.settings[scale_setting] = nlohmann::json(*options.scale).dump();
}

LevelOptions with_recorded(LevelOptions given, const Volume& volume) {
    read(volume, scene_setting, given.scene, is_scene);
    read(volume, ignore_setting, given.ignore);
    read(volume, default_albedo_setting, given.default_albedo, is_albedo);
    read(volume, missing_textures_setting, given.missing_textures, is_missing_textures);
    read(volume, scale_setting, given.scale, is_scale);
    return given;
}

std::vector<std::string> settings_that_differ(const Volume& a, const Volume& b) {
    std::vector<std::string> differing;
    for (const char* name : {scene_setting, ignore_setting, default_albedo_setting, missing_textures_setting,
                             scale_setting, "environment"}) {
        const auto of_a = a.settings.find(name);
        const auto of_b = b.settings.find(name);
        const bool has_a = of_a != a.settings.end();
        const bool has_b = of_b != b.settings.end();
        if (has_a != has_b || (has_a && of_a->second != of_b->second)) differing.emplace_back(name);
    }
    return differing;
}

}  // namespace lightgrid
