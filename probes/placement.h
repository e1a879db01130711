#pragma once

#include "core/tracer.h"
#include "probes/volume.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <functional>

/// Where the probes of a lattice stand: freed from solids, holes filled.
namespace lightgrid {

/// What became of the probes of a volume.
struct PlacementCounts {
    std::size_t valid = 0;    // as the lattice has them
    std::size_t moved = 0;    // freed within half a cell
    std::size_t invalid = 0;  // inside something
    std::uint64_t rays = 0;   // of evidence at the lattice points; not those that looked for a better place
};

/// What light tells of a point besides its surroundings.
struct LightEvidence {
    /// How much light gets to a point (relative to Scene::origin), as a share of what points of the level usually get;
    /// a rough look will do. Empty where the level has no light at all: then darkness tells nothing.
    std::function<double(glm::vec3)> share;
    /// The environment is not black: rays that leave the level see light. Without, they tell no more than back faces.
    bool has_sky = false;
};

/// Sets states and offsets of all probes of the grids. A probe is inside something, or outside of a level without a
/// sky, where it sees back faces almost everywhere, near ones above all, and little light; or where it is enclosed,
/// sees many back faces, and gets no light at all. Winding lies: where there is light, a probe is free.
///
/// A probe inside something, or too near to a surface, is moved by the least offset within half a cell that frees it:
/// out of the solid that it is in, but through no other surface, and not out of its grid's box, unless no probe that it
/// shares a cell with is valid (on a slab, what is above it counts). A probe on its grid's border that a wall hides from
/// most of its cells, as the outer wall of a room hides what is behind it, is moved through that wall. Probes of a list
/// stay where they are and are marked only.
///
/// done  called with how many slots have been come to, from any thread, one at a time; what it throws ends the work and
///       comes out
PlacementCounts place_probes(Volume& volume, const Tracer& tracer, const LightEvidence& light,
                             const std::function<void(std::size_t)>& done = {});

/// Gives invalid probes the light of valid neighbours that they reach through nothing but the surface of what they are
/// in, ring by ring, and then of any neighbour, so that plain trilinear filtering never reads black. States become
/// `filled`, or `missing` where no probe of the grid is valid. Returns how many were filled.
std::size_t fill_invalid(Volume& volume, const Tracer& tracer);

/// True where the surroundings say that a point is free: nothing within `clearance`, not inside a solid.
[[nodiscard]] bool is_free(const Tracer& tracer, glm::vec3 point, float clearance, const LightEvidence& light);

/// Within 0.1 spacings of a point or spot light. These have no size, and near them irradiance squared grows as
/// 1 / distance^4: over all space up to the light its integral has no value.
///
/// spacing  metres between probes before any refinement
[[nodiscard]] bool is_at_light(const Tracer& tracer, glm::vec3 point, double spacing);

/// True where an object may be, so that error there counts: free, with no surface within 0.01 spacings, and not at a
/// light.
[[nodiscard]] bool is_open(const Tracer& tracer, glm::vec3 point, double spacing, const LightEvidence& light);

}  // namespace lightgrid
