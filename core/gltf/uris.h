#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace lightgrid::gltf {

/// %20 -> space. What is no valid escape stays as it is.
[[nodiscard]] std::string percent_decoded(std::string_view uri);

/// A file that a level names.
struct NamedFile {
    std::filesystem::path path;  // where it is not found: where the name says that it should be
    bool found = false;
    bool backslashes = false;  // found by reading backslashes as slashes
    bool elsewhere = false;    // found without the folders, or some of them, that the name begins with
    bool other_case = false;   // found in other upper and lower case (of ASCII)
};

/// Whether a URI is of a scheme that names no file on a disc: "http:", "blob:". "file:" and drives ("C:") do.
[[nodiscard]] bool is_remote(std::string_view uri);

/// The file that a URI means, as exporters write them: with or without escapes, with backslashes in place of slashes, in
/// another case than the disc has it, with the folders of the machine that it was written on. The name as it stands goes
/// first, then its own case, then what is nearest to it. A name in another case counts where only one file has it.
///
/// uri     neither empty, nor remote, nor a data URI
/// folder  of the level
[[nodiscard]] NamedFile find_named_file(const std::filesystem::path& folder, const std::string& uri);

}  // namespace lightgrid::gltf
