#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/tracer.h"
#include "probes/volume.h"

/// Where probes stand: lattices over boxes, probes freed from solids, holes filled.
namespace lightgrid {

struct PlacementOptions {
    std::optional<double> spacing;  // metres between probes at most; none: chosen from the boxes' size
    std::vector<Box> boxes;         // level coordinates; empty: the level's markers, else its bounds
    std::int64_t max_probes = 65536;
};

struct GridChoice {
    std::vector<Grid> grids;
    std::string why;  // one sentence for the user
};

/// Lattices that span the boxes exactly, with cells as near to cubes as whole numbers allow. Throws Error before anything
/// is allocated where they would hold more than max_probes.
[[nodiscard]] GridChoice choose_grids(const Scene& scene, const PlacementOptions& options);

/// What became of the probes of a volume.
struct PlacementCounts {
    std::size_t valid = 0;    // as the lattice has them
    std::size_t moved = 0;    // freed within half a cell
    std::size_t invalid = 0;  // inside something
    std::uint64_t rays = 0;
};

/// Light that a point receives, roughly: decides whether a point that sees back faces all round is inside a solid (dark)
/// or in a shell that is wound inside out (lit). Relative to Scene::origin.
using LightEvidence = std::function<bool(glm::vec3)>;

/// Sets states and offsets of all probes of the grids. A probe is inside something where it is enclosed and sees back
/// faces almost everywhere, near ones above all, and no light; it is moved by the least offset within half a cell that
/// frees it, and not out of its grid's box. Probes of a list stay where they are and are marked only.
PlacementCounts place_probes(Volume& volume, const Tracer& tracer, const LightEvidence& is_lit);

/// Gives invalid probes the light of valid neighbours that no front face hides from them, nearest rings first, and then
/// of any neighbour, so that plain trilinear filtering never reads black. States become `filled`, or `missing` where
/// no probe of the grid is valid. Returns how many were filled.
std::size_t fill_invalid(Volume& volume, const Tracer& tracer);

/// True where the surroundings say that a point is free: nothing within `clearance`, not inside a solid. For held-out
/// points as much as for probes.
[[nodiscard]] bool is_free(const Tracer& tracer, glm::vec3 point, float clearance, const LightEvidence& is_lit);

}  // namespace lightgrid
