#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace lightgrid {

/// All bytes of a file. Throws Error (Fault::input) that says why it cannot be read.
[[nodiscard]] std::string read_whole_file(const std::filesystem::path& path);

/// Writes a file whole or not at all: to a temporary file in the same folder, flushed to the disk, then renamed. What
/// was there before stays until then; a symbolic link stays and its target is replaced; devices and pipes are written
/// to as they are. Throws Error (Fault::work) when the disk refuses.
void write_whole_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace lightgrid
