#pragma once

#include "probes/error_report.h"
#include "probes/sampler.h"
#include "probes/volume.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lightgrid {

/// A way to keep a volume and to read it: how wrong, how long, how large.
struct LookUpCost {
    Interpolation interpolation = Interpolation::trilinear;
    int bands = 1;
    bool half = false;
    ErrorPart error;         // total relRMSE at the held-out points
    double nanoseconds = 0;  // from position and normal to irradiance; one thread, places spread over the grids
    std::size_t bytes = 0;   // of a probe's coefficients
};

/// Every number of bands up to the volume's own, as float and rounded to half, trilinear and nearest. Half takes as
/// long as float: a Sampler holds floats, which load_volume makes of half. The time is the least of several runs, for
/// what else a machine does only adds to it.
///
/// volume  with cells, not rounded
[[nodiscard]] std::vector<LookUpCost> compare_look_ups(const Volume& volume, const HeldOut& reference,
                                                       std::uint64_t seed);

}  // namespace lightgrid
