#pragma once

#include "probes/bake.h"

#include <optional>
#include <string>
#include <vector>

/// What less error would cost, as advice that can be followed: each option is one that level-bake accepts for this level.
namespace lightgrid {

/// One step against a part of the error.
struct Remedy {
    std::string part;
    std::string change;
    std::string option;  // for the same call, in place of options of these names
    double relrmse = 0;  // of the whole, then
    std::string assumes;
    double seconds = 0;      // of gathering
    double size_factor = 1;  // of the volume
};

/// None where no error was measured.
///
/// gather_seconds   what gathering took
/// metres_per_unit  of the level
[[nodiscard]] std::vector<Remedy> find_remedies(const BakePlan& plan, const BakeResult& result,
                                                const BakeOptions& options, double gather_seconds,
                                                double metres_per_unit);

/// What half of the error would cost by more samples alone.
struct Halving {
    double relrmse = 0;                    // half of the error
    double floor = 0;                      // what is left without any noise
    std::optional<double> samples_factor;  // none: samples alone cannot halve it
    std::optional<double> seconds;         // of gathering
};
/// None where no error was measured, or it is 0.
[[nodiscard]] std::optional<Halving> find_halving(const BakeResult& result, double gather_seconds);

}  // namespace lightgrid
