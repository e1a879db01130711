#pragma once

#include "probes/volume.h"

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

/// A volume as an OpenEXR file; FORMAT.md beside this file describes it to other programs.
namespace lightgrid {

/// The version that save_volume writes and the only one that load_volume reads.
inline constexpr int volume_format = 1;

/// What the numbers mean, as the header says it.
inline constexpr std::string_view volume_conventions =
    "Incident radiance, cd/m^2, direct light included; real orthonormal SH without Condon-Shortley phase, (l, m) at "
    "l(l+1)+m; right-handed, +Y up, metres; linear Rec.709";

/// Writes an OpenEXR file, whole or not at all: a temporary file beside it, renamed at the end. Throws Error
/// (Fault::work when the disk refuses). The bytes depend on the volume alone.
void save_volume(const Volume& volume, const std::filesystem::path& path);

/// The bytes of that file.
[[nodiscard]] std::string encode_volume(const Volume& volume);

/// Reads what save_volume wrote. Throws Error for anything else, naming what is missing or wrong.
[[nodiscard]] Volume load_volume(const std::filesystem::path& path);

/// Reads the bytes of such a file; `name` is what messages call it.
[[nodiscard]] Volume decode_volume(std::span<const std::byte> bytes, const std::string& name);

}  // namespace lightgrid
