#pragma once

#include "core/gltf.h"
#include "probes/volume.h"

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

namespace lightgrid {

/// The options that change a level: what level-bake, `lightgrid reference`, `draw` and fly-through share.
struct LevelOptions {
    std::optional<int> scene;                        // none: the file's own choice
    std::optional<std::vector<std::string>> ignore;  // patterns, see LoadOptions; empty ones fit nothing
    std::optional<double> default_albedo;
    std::optional<std::string> missing_textures;  // "warn" or "error"
    std::optional<double> scale;                  // metres per unit of the file
};

void add_level_options(CLI::App& app, LevelOptions& options);

/// The names of those that were given, "--scene", for a program that has no level to apply them to.
[[nodiscard]] std::vector<std::string> names_of(const LevelOptions& options);

[[nodiscard]] LoadOptions load_options(const LevelOptions& options);

/// Of the coordinates of a volume, as --scale said. Throws Error as with_recorded() does.
[[nodiscard]] double metres_per_unit(const Volume& volume);

/// Adds those that were given to a volume's settings.
void record(const LevelOptions& options, Volume& volume);
/// What was given, and for the rest what the level of a volume was baked with. Throws Error for settings that do not
/// read as record() writes them.
[[nodiscard]] LevelOptions with_recorded(LevelOptions given, const Volume& volume);

/// Of what changes a level or the light around it, what two volumes were baked with differently: "ignore",
/// "environment". Names of settings.
[[nodiscard]] std::vector<std::string> settings_that_differ(const Volume& a, const Volume& b);

}  // namespace lightgrid
