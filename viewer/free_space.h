#pragma once

#include "core/tracer.h"
#include "probes/volume.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace lightgrid {

/// Where one can fly: points of a lattice over a volume that its valid probes see, straight or round corners, and the
/// straight lines between neighbours that meet nothing. So a point is free because a probe is, whatever the winding. There
/// is ground below every point, so that nobody flies under a level or beside it; but not in a level that has none.
struct FreeSpace {
    struct Link {
        std::uint32_t to = 0;  // point
        float length = 0;      // metres
    };
    double spacing = 0;                     // between points of the lattice, metres
    float room = 0;                         // that every point has around it at least, metres
    std::vector<glm::vec3> points;          // relative to Scene::origin
    std::vector<float> clearance;           // see clearance_at(), at most most_clearance cells
    std::vector<std::uint32_t> first_link;  // per point, and one more: its links start there
    std::vector<Link> links;                // both ways
};

inline constexpr float most_clearance = 3;  // in units of FreeSpace::spacing

/// Straight lines from a to b meet nothing; positions relative to Scene::origin.
[[nodiscard]] bool is_clear(const Tracer& tracer, glm::vec3 a, glm::vec3 b);

/// To the nearest surface in 26 directions, at most `most`.
[[nodiscard]] float clearance_at(const Tracer& tracer, glm::vec3 point, float most);

/// Only the largest connected part is kept.
///
/// clearances  in cells, falling: points with less around them are left out, by the first for which `enough` of the
///             points remain that are left by the last
/// enough      0 to 1
/// returns     empty where no probe is valid or there is no room
[[nodiscard]] FreeSpace find_free_space(const Tracer& tracer, const Volume& volume, std::span<const float> clearances,
                                        double enough);

}  // namespace lightgrid
