#include "viewer/background_bake.h"

#include <chrono>
#include <utility>

namespace lightgrid {
namespace {

/// Thrown through plan_bake and run_bake to end them.
struct Stopped {};

}  // namespace

BackgroundBake::BackgroundBake(const PathTracer& paths, BakeOptions options, std::uint32_t most_samples) {
    options.measure_error = false;
    options.target.samples = first_samples;
    thread_ = std::jthread([this, &paths, options = std::move(options), most_samples](const std::stop_token& stop) {
        std::exception_ptr failure;
        try {
            work(stop, paths, options, most_samples);
        } catch (const Stopped&) {  // as asked
        } catch (...) {
            failure = std::current_exception();
        }
        const std::lock_guard lock(mutex_);
        failure_ = failure;
        status_.working = false;
    });
}

BackgroundBake::~BackgroundBake() = default;  // a jthread asks to stop, and waits

void BackgroundBake::stop() noexcept {
    thread_.request_stop();
}

void BackgroundBake::work(const std::stop_token& stop, const PathTracer& paths, const BakeOptions& options,
                          std::uint32_t most_samples) {
    const auto start = std::chrono::steady_clock::now();
    std::uint32_t samples = 0;
    const Progress progress = [&](const Doing& doing) {
        if (stop.stop_requested()) throw Stopped();
        const std::lock_guard lock(mutex_);
        status_.stage = doing.stage;
        status_.share = doing.share;
        status_.samples = samples;
    };
    BakePlan plan = plan_bake(paths, options, progress);
    for (samples = first_samples;; samples *= 4) {
        set_samples(plan, samples);
        BakeResult result = run_bake(paths, plan, options, progress);
        if (stop.stop_requested()) return;
        std::optional<BakedVolume> baked(std::in_place);
        baked->volume = std::move(result.volume);
        baked->samples = samples;
        baked->noise = result.noise.relrmse;
        baked->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        baked->last = samples > most_samples / 4;
        const bool last = baked->last;
        {
            const std::lock_guard lock(mutex_);
            finished_.swap(baked);
        }  // one that nobody took dies here, outside of the lock
        if (last) return;
    }
}

std::optional<BakedVolume> BackgroundBake::take() {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    return std::exchange(finished_, std::nullopt);
}

BackgroundBake::Status BackgroundBake::status() const {
    const std::lock_guard lock(mutex_);
    return status_;
}

}  // namespace lightgrid
