#pragma once

#include "core/environment.h"
#include "core/environment_layout.h"

#include <filesystem>
#include <string>
#include <vector>

namespace lightgrid {

struct EnvironmentOptions {
    EnvironmentLayout layout = EnvironmentLayout::automatic;
    float rotation_deg = 0;  // counter-clockwise about +Y seen from above
    float scale = 1;         // of radiance, not negative
    std::string layer = {};  // of an OpenEXR image; empty: chosen, see decode_radiance
};

struct LoadedEnvironment {
    Environment environment;
    EnvironmentLayout layout = EnvironmentLayout::equirectangular;  // that it was read as
    std::vector<std::string> notices;                               // what was assumed or repaired, for the user
};

/// Reads an environment from any picture that read_radiance takes. `automatic` goes by OpenEXR's `envmap` attribute,
/// then by shape; a layout that is named overrides both, so that `equirectangular` reads a file as it is whatever its
/// attribute says. Negative pixels, which lossy compression leaves behind, become 0.
///
/// Throws Error naming the file: unreadable, of a shape that fits no layout or not the one named, not finite, too
/// bright.
[[nodiscard]] LoadedEnvironment load_environment(const std::filesystem::path& path,
                                                 const EnvironmentOptions& options = {});

}  // namespace lightgrid
