#pragma once

#include "probes/gather.h"
#include "probes/held_out.h"
#include "probes/sampler.h"
#include "probes/volume.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// How wrong a volume is: measured at held-out points against the path tracer, and split by cause.
///
/// At every point x the reference comes as two independent halves A and B, so that its own noise does not count:
///
///     relRMSE^2 = sum (E_vol - A)(E_vol - B) / sum A B       over points, 64 normals, R, G, B
///
///     bands          (A - A_sh)(B - B_sh)             A_sh: irradiance of the truncated SH at x
///     noise          sum_c w_c^2 sum_i A_l^2 var_i / (4 pi)   corners c with weights w_c; exact mean over all normals
///     storage        (E_vol - E_float)^2                E_float: the same look-up before its numbers were rounded
///     bias           (C_a - A')(C_b - B')               with a surface cache: cached minus true at x (cache_bias.h)
///     interpolation  (A_sh - E_vol)(B_sh - E_vol) - noise - storage - bias
///     cross          (E_vol - A_sh)(B_sh - B) + (E_vol - B_sh)(A_sh - A), what bands and the rest have in common
///
/// total = bands + noise + storage + bias + interpolation + cross, exactly.
///
/// Sums count each point with its weight (held_out.h). Points are the sampling unit: 95 % intervals come from 1,000
/// resamplings of points with replacement (bootstrap-t).
namespace lightgrid {

struct Interval {
    double low = 0;
    double high = 0;
};

/// A part of the error, as a share of the root mean square irradiance; negative where an unbiased estimate of its
/// square is.
struct ErrorPart {
    double relrmse = 0;
    Interval interval;
};

struct ErrorReport {
    std::size_t points = 0;
    std::size_t normals = 0;
    ErrorPart total, without_bands;  // the latter: as if the truncated series were the truth
    ErrorPart noise, bands, interpolation, storage, cross;
    std::optional<ErrorPart> bias;     // of a surface cache
    double p50 = 0, p95 = 0, p99 = 0;  // of |dE| / max(mean E at x, 1 % of the level's median E)
    struct Worst {
        glm::dvec3 position{0};
        double relative_error = 0;  // root mean square over normals and colours, by the same measure
    };
    std::vector<Worst> worst;  // the largest few, worst first
};

/// Mean over all normals of squared irradiance (lux^2, R + G + B) from coefficients of radiance; of its variance, from
/// standard errors of coefficients that are independent.
[[nodiscard]] double mean_square_irradiance(std::span<const glm::vec3> sh);

/// What irradiance at points loses to bands that are left out: relRMSE with 1, 2, ... `most_bands`, from two independent
/// gathers.
[[nodiscard]] std::vector<double> measure_bands(const PathTracer& paths, const std::vector<glm::vec3>& points,
                                                int most_bands, std::uint32_t samples, const GatherRays& rays,
                                                std::uint64_t seed, PathCounts& counts);

/// The bias that was traced, by itself; 0 where none was.
[[nodiscard]] ErrorPart bias_of(const HeldOut& held_out);

/// rounded_from  the volume before its numbers were rounded for storage; none: they were not, and storage is 0
/// look_up       how the volume is read
[[nodiscard]] ErrorReport measure_error(const Volume& volume, const HeldOut& reference,
                                        const Volume* rounded_from = nullptr, const SampleOptions& look_up = {});

/// Its total alone, without what the parts cost.
[[nodiscard]] ErrorPart measure_total(const Volume& volume, const HeldOut& reference,
                                      const SampleOptions& look_up = {});

}  // namespace lightgrid
