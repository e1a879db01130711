#pragma once

#include "probes/bake.h"

#include <cstdint>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace lightgrid {

/// A volume that is done, and how good it is.
struct BakedVolume {
    Volume volume;
    std::uint32_t samples = 0;  // gather rays per probe
    double noise = 0;           // BakeResult::noise: relative standard error of irradiance at the probes
    double seconds = 0;         // since the start
    bool last = false;          // no better one will follow
};

/// Bakes beside the frame loop: first with few samples, then again and again with four times as many, each volume the
/// same as run_bake makes with that number. On two cores the first stands about a second after the start in most levels.
class BackgroundBake {
  public:
    static constexpr std::uint32_t first_samples = 16;  // the fewest that tell a noise: one a replicate

    /// Starts at once. Keeps a reference to `paths`, which must outlive this.
    ///
    /// options       its error is not measured, and `samples` is not read
    /// most_samples  of the last volume; rounded down to first_samples times a power of four, but at least that
    BackgroundBake(const PathTracer& paths, BakeOptions options, std::uint32_t most_samples = 4096);
    /// Stops and waits.
    ~BackgroundBake();
    BackgroundBake(const BackgroundBake&) = delete;
    BackgroundBake& operator=(const BackgroundBake&) = delete;

    /// The newest volume, once; nothing where there is none that was not taken before. Throws, once, what the bake
    /// threw. Never waits for the bake: cheap enough for every frame.
    [[nodiscard]] std::optional<BakedVolume> take();

    struct Status {
        bool working = true;
        std::string stage;          // "place", "cache", "gather"
        double share = 0;           // of the stage
        std::uint32_t samples = 0;  // that the volume being made will have; 0 while places are looked for
    };
    [[nodiscard]] Status status() const;

    /// Asks the bake to end; it does within the time of a few rays, but for the filling of invalid probes.
    void stop() noexcept;

  private:
    void work(const std::stop_token& stop, const PathTracer& paths, const BakeOptions& options,
              std::uint32_t most_samples);

    mutable std::mutex mutex_;  // of all below; held for a move at most
    std::optional<BakedVolume> finished_;
    std::exception_ptr failure_;
    Status status_;
    std::jthread thread_;  // last: the others must be there while it runs
};

}  // namespace lightgrid
