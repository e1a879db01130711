#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

/// What a program tells its user while it works: standard error only, nothing with --quiet.
namespace lightgrid {

class Messages {
  public:
    explicit Messages(bool quiet, bool verbose = false);

    void line(const std::string& text) const;
    void notice(const std::string& text) const;   // something was ignored, assumed or repaired
    void warning(const std::string& text) const;  // the result may not be what was wanted
    [[nodiscard]] bool quiet() const noexcept { return quiet_; }
    [[nodiscard]] bool verbose() const noexcept { return verbose_; }  // every detail is welcome
    [[nodiscard]] bool terminal() const noexcept { return terminal_; }

  private:
    bool quiet_;
    bool verbose_;
    bool terminal_;  // standard error is one: a moving bar, and colour unless NO_COLOR is set
    bool colour_;
};

/// One bar that moves on a terminal; elsewhere a plain line when a stage starts and at each quarter of it.
class ProgressLine {
  public:
    explicit ProgressLine(const Messages& messages) : messages_(&messages) {}

    /// share in [0, 1]; rays so far in this stage, 0: not known; error: relRMSE so far, where it is known
    void update(const std::string& stage, double share, std::uint64_t rays, std::optional<double> error = {});
    /// Removes the bar.
    void finish();

  private:
    void draw(double share, std::uint64_t rays, const std::string& error);

    const Messages* messages_;
    std::string stage_;
    std::chrono::steady_clock::time_point stage_start_;
    std::chrono::steady_clock::time_point last_drawn_;
    int quarters_ = 0;
    bool drawn_ = false;
};

/// "0.05 ms", "3.2 s", "2 min 5 s", "1 h 20 min".
[[nodiscard]] std::string duration_text(double seconds);
/// "12 kB", "3.4 MB".
[[nodiscard]] std::string bytes_text(double bytes);

}  // namespace lightgrid
