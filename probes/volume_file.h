#pragma once

#include <filesystem>

#include "probes/volume.h"

namespace lightgrid {

/// Writes an OpenEXR file, whole or not at all: a temporary file beside it, renamed at the end. Throws Error (Fault::work
/// when the disk refuses). The bytes depend on the volume alone.
void save_volume(const Volume& volume, const std::filesystem::path& path);

/// Reads what save_volume wrote. Throws Error for anything else, naming what is missing or wrong.
[[nodiscard]] Volume load_volume(const std::filesystem::path& path);

}  // namespace lightgrid
