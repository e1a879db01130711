#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace lightgrid {

/// All bytes of a file. Throws Error (Fault::input) that says why it cannot be read.
[[nodiscard]] std::string read_whole_file(const std::filesystem::path& path);

/// Writes a file whole or not at all: to a file in the same folder that has no name until it is whole and flushed to
/// the disk (where the file system knows no such files, a hidden name), so that a process that dies leaves nothing.
/// What was there before stays until then; a symbolic link stays and its target is replaced; devices and pipes are
/// written to as they are. Throws Error (Fault::work) when the disk refuses.
void write_whole_file(const std::filesystem::path& path, std::string_view bytes);

/// Throws Error (Fault::input) where write_whole_file would fail, as far as that can be told without writing: there is
/// no folder, or it takes no files; `path` is a folder.
void check_writable(const std::filesystem::path& path);

}  // namespace lightgrid
