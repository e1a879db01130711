#pragma once

#include <chrono>

namespace lightgrid {

/// Wall clock, seconds.
class Stopwatch {
  public:
    /// Since it was made.
    [[nodiscard]] double seconds() const { return since(start_); }
    /// Since the last lap, or since it was made.
    double lap() {
        const double seconds = since(lap_);
        lap_ = Clock::now();
        return seconds;
    }

  private:
    using Clock = std::chrono::steady_clock;
    [[nodiscard]] static double since(Clock::time_point time) {
        return std::chrono::duration<double>(Clock::now() - time).count();
    }

    Clock::time_point start_ = Clock::now();
    Clock::time_point lap_ = start_;
};

}  // namespace lightgrid
