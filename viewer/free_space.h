#pragma once

#include "core/tracer.h"
#include "probes/volume.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace lightgrid {

/// Where one can fly: points of a lattice over a volume that its valid probes see, straight or round corners, and the
/// straight lines between neighbours that meet nothing. So a point is free because a probe is, whatever the winding.
struct FreeSpace {
    struct Link {
        std::uint32_t to = 0;  // point
        float length = 0;      // metres
    };
    double spacing = 0;                     // between points of the lattice, metres
    std::vector<glm::vec3> points;          // relative to Scene::origin
    std::vector<float> clearance;           // to the nearest surface in some directions, at most most_clearance cells
    std::vector<float> fronts;              // share of these directions in which there is the front of a surface
    std::vector<std::uint32_t> first_link;  // per point, and one more: its links start there
    std::vector<Link> links;                // both ways
};

inline constexpr float most_clearance = 3;  // in units of FreeSpace::spacing

/// Straight lines from a to b meet nothing; positions relative to Scene::origin.
[[nodiscard]] bool is_clear(const Tracer& tracer, glm::vec3 a, glm::vec3 b);

/// To the nearest surface in 26 directions, at most `most`.
[[nodiscard]] float clearance_at(const Tracer& tracer, glm::vec3 point, float most);

/// Only the largest connected part is kept, of points that have at least `clearance` cells around them. Empty where no
/// probe is valid.
[[nodiscard]] FreeSpace find_free_space(const Tracer& tracer, const Volume& volume, float clearance);

}  // namespace lightgrid
