#include "viewer/volume_watch.h"

#include "core/error.h"
#include "probes/volume_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <sys/stat.h>

namespace lightgrid {
namespace {

bool meets(const Grid& grid, const Box& box) {
    const glm::dvec3 far = grid.position(grid.counts - 1);
    return glm::all(glm::lessThanEqual(grid.origin, box.max)) && glm::all(glm::greaterThanEqual(far, box.min));
}

}  // namespace

std::string why_not_of_level(const Volume& volume, const Scene& level) {
    if (!volume.has_cells()) return "it is a list of probes, which has no cells to interpolate in";
    const auto named = volume.settings.find("level");
    if (named != volume.settings.end() && named->second != level.name) {
        return fmt::format("it was baked from {}, but this level is {}", named->second, level.name);
    }
    if (std::none_of(volume.grids.begin(), volume.grids.end(),
                     [&](const Grid& grid) { return meets(grid, level.bounds); })) {
        return "none of its grids reaches into the level";
    }
    return {};
}

VolumeWatch::VolumeWatch(std::filesystem::path path, const Scene& level)
    : path_(std::move(path)), level_(level), known_(stamp_of(path_)), seen_(known_) {}

VolumeWatch::Stamp VolumeWatch::stamp_of(const std::filesystem::path& path) noexcept {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return {};
    return {std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec,
            static_cast<std::uint64_t>(status.st_size), static_cast<std::uint64_t>(status.st_ino), true};
}

VolumeWatch::News VolumeWatch::read(const std::filesystem::path& path, const Scene& level) {
    try {
        Volume volume = load_volume(path);
        const std::string why_not = why_not_of_level(volume, level);
        if (why_not.empty()) return {std::move(volume), fmt::format("{}: reloaded", path.string())};
        return {{}, fmt::format("{}: {}. The old volume stays.", path.string(), why_not)};
    } catch (const Error& error) {
        return {{}, fmt::format("{} The old volume stays.", error.what())};
    }
}

std::optional<VolumeWatch::News> VolumeWatch::poll() {
    const auto now = std::chrono::steady_clock::now();
    const Stamp stamp = stamp_of(path_);
    if (stamp != seen_) {
        seen_ = stamp;
        seen_since_ = now;
    }
    if (reading_.valid()) {
        if (reading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
        News news = reading_.get();
        // Written again in the meantime: the next reading tells.
        if (stamp != known_) return std::nullopt;
        return news;
    }
    if (stamp == known_ || now - seen_since_ < settle) return std::nullopt;
    known_ = stamp;
    if (!stamp.exists) return News{{}, fmt::format("{}: is gone. The old volume stays.", path_.string())};
    reading_ = std::async(std::launch::async, [path = path_, &level = level_] { return read(path, level); });
    return std::nullopt;
}

}  // namespace lightgrid
