#include "probes/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

namespace lightgrid {
namespace {

/// The parts that are in the way, largest first: the largest, and what alone takes half of the target.
std::string what_is_left(const ErrorReport& error, double wanted, bool counts_bands) {
    std::vector<std::pair<double, std::string>> parts{{error.interpolation.relrmse, "interpolation"},
                                                      {error.noise.relrmse, "noise"},
                                                      {error.bias.value_or(ErrorPart{}).relrmse, "bias"}};
    if (counts_bands) parts.emplace_back(error.bands.relrmse, "bands");
    std::sort(parts.begin(), parts.end(), std::greater<>());
    std::vector<std::string> named;
    for (const auto& [value, name] : parts) {
        if (named.empty() || value > 0.5 * wanted) named.push_back(fmt::format("{} {}", name, rounded_percent(value)));
    }
    return fmt::format("{}", fmt::join(named, ", "));
}

/// To two digits, or as many as tell it from what was wanted: 2.004 % of 2 %, not 2 % of 2 %.
std::string percent_beside(double share, double wanted) {
    std::string text = rounded_percent(share);
    if (share == wanted || text != rounded_percent(wanted)) return text;
    for (int digits = 3; digits <= 9 && text == rounded_percent(wanted); ++digits)
        text = fmt::format("{:.{}g} %", 100 * share, digits);
    return text;
}

Verdict not_judged(const std::string& because) {
    return {false, {}, "not judged: " + because};
}

}  // namespace

Verdict judge(const Target& target, const Evidence& evidence) {
    const bool can_miss = !target.samples && !target.seconds;
    const bool is_black = evidence.points > 0 && evidence.is_black;
    if (is_black && !evidence.is_tested) {
        return {true, can_miss ? std::optional(false) : std::nullopt,
                fmt::format("no light reached any of {} points", evidence.points)};
    }
    if (evidence.missing_textures > 0) {
        return not_judged(
            fmt::format("{} texture{} missing", evidence.missing_textures, evidence.missing_textures == 1 ? "" : "s"));
    }
    if (!evidence.has_light) return not_judged("nothing shines, all is black");
    if (evidence.is_all_shut_out) return not_judged("every light is kept from the level");
    if (is_black) {
        const bool is_judged = !evidence.is_shut_out;
        return {is_judged, can_miss && is_judged ? std::optional(true) : std::nullopt,
                fmt::format("all is dark: rays to every light were stopped at each of {} points", evidence.points)};
    }
    if (!can_miss) return {};
    const double wanted = target.error.value_or(default_error);
    const auto percent = [&](double share) { return percent_beside(share, wanted); };
    if (evidence.error == nullptr) {
        const bool is_met = evidence.noise < wanted;
        return {true, is_met,
                fmt::format("{}: noise {} of {}", is_met ? "target met" : "target not reached", percent(evidence.noise),
                            rounded_percent(wanted))};
    }
    const ErrorPart& counted = target.error ? evidence.error->total : evidence.error->without_bands;
    if (counted.interval.high < wanted) {
        return {true, true,
                fmt::format("target met: {} at most, of {}", percent(counted.interval.high), rounded_percent(wanted))};
    }
    if (counted.relrmse < wanted) {
        return {true, false,
                fmt::format("target {} missed: {}, but up to {} is possible with {} places", rounded_percent(wanted),
                            percent(counted.relrmse), percent(counted.interval.high), evidence.error->points)};
    }
    return {true, false,
            fmt::format("target not reached: {}", what_is_left(*evidence.error, wanted, target.error.has_value()))};
}

}  // namespace lightgrid
