#pragma once

#include "core/scene.h"
#include "probes/volume.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <future>
#include <optional>
#include <string>

namespace lightgrid {

/// Why a volume cannot light this level: it is a probe list, it names another level, or no grid of it reaches into the
/// level's bounds. Empty: it can.
[[nodiscard]] std::string why_not_of_level(const Volume& volume, const Scene& level);

/// Looks whether a volume's file has been replaced, and reads it anew.
class VolumeWatch {
  public:
    /// Make it before the file is read first, so that no change is missed. Keeps a reference to `level`.
    VolumeWatch(std::filesystem::path path, const Scene& level);

    struct News {
        std::optional<Volume> volume;  // to show instead of the old one
        std::string notice;            // for the user: what was reloaded, or why it was not
    };
    /// To be called now and then, at best every frame: costs a question to the file system. A file is read in a thread
    /// of its own once it has stayed as it is for `settle`. What cannot be read whole, or is not of this level, is
    /// reported once and leaves the old volume in place.
    [[nodiscard]] std::optional<News> poll();

    static constexpr std::chrono::milliseconds settle{250};

  private:
    /// What changes when a file is written or replaced.
    struct Stamp {
        std::int64_t modified_ns = 0;
        std::uint64_t size = 0;
        std::uint64_t inode = 0;
        bool exists = false;

        bool operator==(const Stamp&) const = default;
    };
    [[nodiscard]] static Stamp stamp_of(const std::filesystem::path& path) noexcept;
    [[nodiscard]] static News read(const std::filesystem::path& path, const Scene& level);

    std::filesystem::path path_;
    const Scene& level_;
    Stamp known_;  // of what has been dealt with
    Stamp seen_;   // at the last poll
    std::chrono::steady_clock::time_point seen_since_;
    std::future<News> reading_;  // last: its thread ends first
};

}  // namespace lightgrid
