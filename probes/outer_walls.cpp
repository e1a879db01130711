#include "probes/outer_walls.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace lightgrid {
namespace {

constexpr std::uint32_t rays_per_side = 1024;
constexpr double least_wall = 2.0 / 3;
constexpr double most_cut_off = 0.05;  // of the side
/// Of the reach: walls that are nearer to the bounds are at them; others are left on their inner side.
constexpr double near_enough = 0.02;

/// How far in the wall of a side begins; 0 where it has none.
double depth_of_wall(const Tracer& tracer, const Box& bounds, int axis, bool upper, double reach) {
    const double face = upper ? bounds.max[axis] : bounds.min[axis];
    glm::vec3 inward(0);
    inward[axis] = upper ? -1.0F : 1.0F;
    std::vector<double> depths(rays_per_side, std::numeric_limits<double>::infinity());
    for_each_index(rays_per_side, [&](std::size_t i) {
        const glm::dvec2 u(sobol_point(static_cast<std::uint32_t>(i), 0));
        glm::dvec3 share(0);
        share[(axis + 1) % 3] = u.x;
        share[(axis + 2) % 3] = u.y;
        glm::dvec3 start = bounds.min + share * bounds.size();
        start[axis] = face - reach * static_cast<double>(inward[axis]);  // from outside: a wall in the face is met, too
        const Hit hit =
            tracer.closest_hit(glm::vec3(start - tracer.scene().origin), inward, static_cast<float>(2 * reach));
        if (hit.found()) depths[i] = static_cast<double>(hit.distance) - reach;
    });
    std::sort(depths.begin(), depths.end());
    const auto wall = std::lower_bound(depths.begin(), depths.end(), std::numeric_limits<double>::infinity());
    if (static_cast<double>(wall - depths.begin()) < least_wall * rays_per_side) return 0;
    const double depth = depths[static_cast<std::size_t>(most_cut_off * rays_per_side)];
    return depth > near_enough * reach ? depth + near_enough * reach : 0;
}

}  // namespace

Box within_outer_walls(const Tracer& tracer, double reach, std::uint64_t& rays) {
    const Box& bounds = tracer.scene().bounds;
    Box within = bounds;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(bounds.size()[axis] > 4 * reach)) continue;  // both walls would be within reach of each other
        within.min[axis] += depth_of_wall(tracer, bounds, axis, false, reach);
        within.max[axis] -= depth_of_wall(tracer, bounds, axis, true, reach);
        rays += 2 * rays_per_side;
    }
    return within;
}

}  // namespace lightgrid
