#include "core/gltf/uris.h"

#include "core/near_names.h"

#include <algorithm>
#include <optional>
#include <system_error>
#include <vector>

namespace lightgrid::gltf {
namespace {

namespace fs = std::filesystem;

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/// The letters before the first colon, where it comes before any slash.
std::string_view scheme_of(std::string_view uri) {
    const std::size_t colon = uri.find(':');
    return colon < uri.find_first_of("/\\") ? uri.substr(0, colon) : std::string_view();
}

bool is_there(const fs::path& path) {
    std::error_code ignored;
    return fs::exists(path, ignored);
}

/// The one entry below `folder` that is called so but for case, if there is exactly one.
std::optional<fs::path> find_in_other_case(fs::path folder, const fs::path& name) {
    for (const fs::path& part : name) {
        if (part.empty()) continue;
        if (is_there(folder / part)) {
            folder /= part;
            continue;
        }
        const std::string wanted = lower_case(part.string());
        std::vector<fs::path> matches;
        std::error_code problem;
        for (fs::directory_iterator entry(folder, problem), end; !problem && entry != end; entry.increment(problem))
            if (lower_case(entry->path().filename().string()) == wanted) matches.push_back(entry->path().filename());
        if (matches.size() != 1) return {};
        folder /= matches.front();
    }
    return folder;
}

/// "c.png" of "b/c.png" and of "C:c.png"; nothing of "c.png".
std::string behind_first_folder(const std::string& path) {
    const std::size_t end = path.find_first_of("/:");
    return end == std::string::npos ? std::string() : path.substr(end + 1);
}

std::optional<NamedFile> find_spelling(const fs::path& folder, const std::vector<std::string>& spellings) {
    for (const bool other_case : {false, true}) {
        for (const std::string& spelling : spellings) {
            if (spelling.empty()) continue;
            const fs::path name = fs::path(spelling).relative_path();
            const std::optional<fs::path> file = other_case ? find_in_other_case(folder, name) : folder / name;
            std::error_code ignored;
            if (file && fs::is_regular_file(*file, ignored)) return NamedFile{*file, true, false, false, other_case};
        }
    }
    return {};
}

}  // namespace

std::string percent_decoded(std::string_view uri) {
    std::string result;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        if (uri[i] == '%' && i + 2 < uri.size() && hex_digit(uri[i + 1]) >= 0 && hex_digit(uri[i + 2]) >= 0) {
            result += static_cast<char>(16 * hex_digit(uri[i + 1]) + hex_digit(uri[i + 2]));
            i += 2;
        } else {
            result += uri[i];
        }
    }
    return result;
}

bool is_remote(std::string_view uri) {
    const std::string_view scheme = scheme_of(uri);
    const bool is_drive = scheme.size() == 1 && is_letter(scheme[0]);
    return !scheme.empty() && !is_drive && lower_case(std::string(scheme)) != "file";
}

NamedFile find_named_file(const fs::path& folder, const std::string& uri) {
    std::string name = uri;
    if (scheme_of(uri).size() > 1) {  // file:///C:/work/wood.png, file://host/wood.png
        name.erase(0, scheme_of(uri).size() + 1);
        if (name.starts_with("//")) name.erase(0, std::min(name.find('/', 2), name.size()));
    }
    std::vector<std::string> spellings{percent_decoded(name), name};
    for (const std::string& spelling : spellings)
        if (is_there(folder / spelling)) return {folder / spelling, true};
    const fs::path wanted = folder / spellings.front();

    const bool has_backslashes = spellings.front().find('\\') != std::string::npos;
    for (std::string& spelling : spellings) std::replace(spelling.begin(), spelling.end(), '\\', '/');
    if (std::optional<NamedFile> file = find_spelling(folder, spellings)) {
        file->backslashes = has_backslashes;
        return *file;
    }
    // The folders of another machine, or those that the file was moved out of, fall away one by one.
    while (true) {
        for (std::string& spelling : spellings) spelling = behind_first_folder(spelling);
        if (spellings.front().empty()) return {wanted};
        std::optional<NamedFile> file = find_spelling(folder, spellings);
        if (!file) continue;
        file->elsewhere = true;
        return *file;
    }
}

}  // namespace lightgrid::gltf
