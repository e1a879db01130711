#include "tools/remedies.h"

#include "core/sh.h"
#include "tools/target_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace lightgrid {
namespace {

/// A grid of half the spacing may end elsewhere at walls and under the sky: so many times as many probes are allowed for.
constexpr double room_for_probes = 1.5;
/// A finer volume of more lattice than this would be refused.
constexpr double most_probes_in_grids = static_cast<double>(max_lattice_bricks) * probes_per_brick;

double square(const ErrorPart& part) {
    return part.relrmse * std::abs(part.relrmse);
}

/// "4.2%", within what --max-error takes.
std::string error_option(double relrmse) {
    return fmt::format("--max-error {:.2g}%", 100 * std::clamp(relrmse, 1e-4, 1.0));
}

/// Of grids whose spacing is divided by `factor`.
double probe_count(const std::vector<Grid>& grids, double factor) {
    double probes = 0;
    for (const Grid& grid : grids) {
        const glm::dvec3 counts = factor * glm::dvec3(grid.counts - 1) + 1.0;
        probes += counts.x * counts.y * counts.z;
    }
    return probes;
}

}  // namespace

std::vector<Remedy> find_remedies(const BakePlan& plan, const BakeResult& result, const BakeOptions& options,
                                  double gather_seconds, double metres_per_unit) {
    if (!result.error) return {};
    const ErrorReport& error = *result.error;
    const Target& target = options.target;
    const auto without = [&](double squares) { return std::sqrt(std::max(square(error.total) - squares, 0.0)); };
    const int bands = result.volume.bands;
    const bool is_refined = !target.samples && !options.placement.spacing;
    std::vector<Remedy> remedies;

    Remedy noise{"noise",
                 "four times the samples",
                 "",
                 without(0.75 * square(error.noise)),
                 "nothing: the noise halves",
                 4 * gather_seconds,
                 1};
    if (target.seconds) {
        noise.change = "four times the time";
        noise.option = fmt::format("--time-budget {:.0f}s", 4 * *target.seconds);
        noise.assumes = "that only the noise falls; grids get finer too";
        remedies.push_back(noise);
    } else if (target.samples && 4.0 * plan.samples <= most_samples) {
        noise.option = fmt::format("--samples {}", 4ULL * plan.samples);
        remedies.push_back(noise);
    } else if (!target.samples && !is_refined) {
        noise.option = error_option(noise.relrmse);
        remedies.push_back(noise);
    }
    if (bands < max_sh_bands) {
        remedies.push_back({"bands", "one band more", fmt::format("--bands {}", bands + 1),
                            without(square(error.bands) + square(error.cross)),
                            "that all that is missing is in that band", gather_seconds,
                            std::pow((bands + 1.0) / bands, 2)});
    }
    if (is_refined && !target.seconds) {
        const double relrmse = without(0.75 * square(error.interpolation));
        remedies.push_back(
            {"interpolation", "eight times the probes, where they serve most",
             fmt::format("{} --max-probes {} --bands {}", error_option(relrmse), 8 * plan.points.size(), bands),
             relrmse, "that it falls as half the spacing makes it: faster where light is smooth, slower at leaks",
             8 * gather_seconds, 8});
    } else if (!is_refined) {
        double spacing = options.placement.spacing.value_or(std::numeric_limits<double>::infinity());
        for (const Grid& grid : result.volume.grids) {
            spacing = std::min(spacing, metres_per_unit * std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z}));
        }
        const double probes = probe_count(result.volume.grids, 2);
        const double allowed = std::ceil(room_for_probes * probes);
        std::string option = fmt::format("--spacing {:.3g}", 0.5 * spacing);
        if (allowed > static_cast<double>(options.placement.max_probes)) {
            option += fmt::format(" --max-probes {:.0f}", allowed);
        }
        if (allowed < most_probes_in_grids) {
            const double factor = probes / probe_count(result.volume.grids, 1);
            remedies.push_back({"interpolation", "half the spacing", option,
                                without(0.75 * square(error.interpolation)),
                                "that it falls as the spacing does: faster where light is smooth, slower at leaks",
                                factor * gather_seconds, factor});
        }
    }
    return remedies;
}

std::optional<Halving> find_halving(const BakeResult& result, double gather_seconds) {
    if (!result.error || !(result.error->total.relrmse > 0)) return {};
    const double total = square(result.error->total);
    const double rest = std::max(total - std::max(square(result.error->noise), 0.0), 0.0);
    Halving halving{0.5 * std::sqrt(total), std::sqrt(rest), {}, {}};
    if (0.25 * total > rest) {
        // The share of noise in the squared error falls as one over the number of samples; the rest stays.
        halving.samples_factor = (total - rest) / (0.25 * total - rest);
        halving.seconds = *halving.samples_factor * gather_seconds;
    }
    return halving;
}

}  // namespace lightgrid
