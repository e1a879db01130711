#pragma once

#include "core/scene.h"
#include "probes/volume.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// Lattices of probes over boxes.
namespace lightgrid {

struct PlacementOptions {
    std::optional<double> spacing;  // metres between probes at most; none: chosen from the boxes' size
    std::vector<Box> boxes;         // level coordinates; empty: the level's markers, else its bounds
    std::int64_t max_probes = 65536;
    double headroom = 2;  // metres above ground open to the sky, at most, where the boxes are the level's bounds
};

struct GridChoice {
    std::vector<Grid> grids;
    std::string why;  // one sentence for the user
};

/// Lattices that span the boxes exactly, with cells as near to cubes as whole numbers allow. Throws Error before
/// anything is allocated where they would hold more than max_probes.
///
/// within  in place of the level's bounds, where it is not empty
[[nodiscard]] GridChoice choose_grids(const Scene& scene, const PlacementOptions& options, const Box& within = {});

}  // namespace lightgrid
