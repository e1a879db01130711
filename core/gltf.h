#pragma once

#include <filesystem>

#include "core/scene.h"

namespace lightgrid {

struct LoadOptions {
    int scene = -1;  // index of the glTF scene; -1: the file's default, else the first
};

/// Reads a .gltf or .glb level. Throws Error naming file and place for anything that would change the light; what no
/// light path reads (animations, cameras, unused materials ...) is reported in Scene::notices instead.
[[nodiscard]] Scene load_level(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace lightgrid
