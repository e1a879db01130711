#include "tools/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <unistd.h>

namespace lightgrid {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int bar_cells = 28;
constexpr std::chrono::milliseconds redraw_every{100};
/// Before this share of a stage is done, the time that is left is a guess not worth printing.
constexpr double share_worth_a_forecast = 0.02;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Nothing where rays are not counted while they are traced.
std::string rate_text(std::uint64_t rays, double seconds) {
    if (rays == 0) return "";
    return fmt::format(", {:.2f} Mrays/s", static_cast<double>(rays) * 1e-6 / std::max(seconds, 1e-3));
}

}  // namespace

Messages::Messages(bool quiet, bool verbose)
    : quiet_(quiet),
      verbose_(verbose),
      terminal_(isatty(STDERR_FILENO) != 0),
      colour_(terminal_ && std::getenv("NO_COLOR") == nullptr) {}

void Messages::line(const std::string& text) const {
    if (!quiet_) fmt::print(stderr, "{}\n", text);
}

void Messages::notice(const std::string& text) const {
    line((colour_ ? "\x1b[2mnotice:\x1b[0m " : "notice: ") + text);
}

void Messages::warning(const std::string& text) const {
    line((colour_ ? "\x1b[33mwarning:\x1b[0m " : "warning: ") + text);
}

void ProgressLine::update(const std::string& stage, double share, std::uint64_t rays, std::optional<double> error) {
    if (messages_->quiet()) return;
    if (stage != stage_) {
        stage_ = stage;
        stage_start_ = Clock::now();
        last_drawn_ = {};
        quarters_ = 0;
        if (!messages_->terminal()) messages_->line(stage + " ...");
    }
    const std::string so_far = error ? fmt::format(", error {:.2f} %", 100 * std::max(*error, 0.0)) : "";
    if (messages_->terminal()) {
        if (Clock::now() - last_drawn_ < redraw_every) return;
        last_drawn_ = Clock::now();
        draw(share, rays, so_far);
    } else if (static_cast<int>(share * 4) > quarters_) {
        quarters_ = static_cast<int>(share * 4);
        messages_->line(fmt::format("{} {:.0f} %{}{}", stage, 25.0 * quarters_,
                                    rate_text(rays, seconds_since(stage_start_)), so_far));
    }
}

void ProgressLine::draw(double share, std::uint64_t rays, const std::string& error) {
    const double seconds = seconds_since(stage_start_);
    const int full = static_cast<int>(std::lround(share * bar_cells));
    const std::string left =
        share > share_worth_a_forecast ? ", " + duration_text(seconds / share * (1 - share)) + " left" : "";
    fmt::print(stderr, "\r\x1b[K{} [{:#<{}}{:.<{}}] {:3.0f} %{}{}{}", stage_, "", full, "", bar_cells - full,
               100 * share, rate_text(rays, seconds), error, left);
    std::fflush(stderr);
    drawn_ = true;
}

void ProgressLine::finish() {
    if (drawn_) fmt::print(stderr, "\r\x1b[K");
    drawn_ = false;
}

std::string duration_text(double seconds) {
    if (seconds < 1e-3) return fmt::format("{:.2g} ms", 1e3 * seconds);
    if (seconds < 10) return fmt::format("{:.2g} s", seconds);
    const auto whole = static_cast<long long>(std::llround(seconds));
    if (whole < 60) return fmt::format("{} s", whole);
    if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
    return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
}

std::string bytes_text(double bytes) {
    if (bytes < 1e3) return fmt::format("{:.0f} bytes", bytes);
    if (bytes < 1e6) return fmt::format("{:.3g} kB", bytes * 1e-3);
    if (bytes < 1e9) return fmt::format("{:.3g} MB", bytes * 1e-6);
    return fmt::format("{:.3g} GB", bytes * 1e-9);
}

}  // namespace lightgrid
