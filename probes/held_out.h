#pragma once

#include "probes/cache_bias.h"
#include "probes/gather.h"
#include "probes/placement.h"
#include "probes/volume.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

/// Points that no probe knows of, with the path tracer's answer there: what a volume is measured against.
///
/// The error is an integral of squares over all free space, and beside a lamp these are hundreds of times the usual
/// ones: of points drawn evenly, one there would decide, or none would be. So half of the points are spread evenly, and
/// half as a rough look finds the square of the light; each counts for the space that it stands for (HeldOut::weights).
/// Whatever the look found, the weighted sums are unbiased.
namespace lightgrid {

struct HeldOut {
    std::vector<glm::dvec3> points;  // level coordinates; independent of each other
    std::vector<double> weights;     // space that each stands for, over what it would be if all were drawn evenly
    Gather a;                        // two independent halves; irradiance along held_out_normals()
    Gather b;
    PathCounts counts;
    std::optional<CacheBias> bias;  // of the cache that lit the volume, at the same points and normals
};

/// 64 directions, spread evenly over the sphere.
[[nodiscard]] const std::vector<glm::vec3>& held_out_normals();

struct HeldOutOptions {
    std::size_t points = 128;
    std::uint32_t samples = 4096;  // per point and half
    int bands = 3;
    std::size_t grids = std::numeric_limits<std::size_t>::max();  // whose boxes count: the first so many
    std::uint64_t seed = 0;
};

/// Draws points in the open space of the volume's boxes (is_open; where boxes overlap, for each of them) and traces
/// them. Empty where no open point was found. The places of probes, and their light, have no part in it.
[[nodiscard]] HeldOut trace_held_out(const Volume& volume, const PathTracer& paths, const LightEvidence& light,
                                     const HeldOutOptions& options);

/// How far a cache is off at held-out points.
void trace_bias(HeldOut& held_out, const PathTracer& paths, const SurfaceCache& cache, const BiasOptions& options);

}  // namespace lightgrid
