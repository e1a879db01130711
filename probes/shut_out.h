#pragma once

#include "probes/paths.h"

#include <glm/glm.hpp>

#include <span>
#include <string>
#include <vector>

/// Lights that bring nothing to any probe, and the mesh that keeps them out: a sky dome round a level with a sun of its
/// own, a bulb within a closed shade.
namespace lightgrid {

struct ShutOut {
    std::string light;            // `the sun "Sun"`, `the sky`, `the lamp "Bulb"`
    int node = -1;                // whose mesh is in its way: index in Scene::node_names; -1: no one mesh is
    bool from_all_points = true;  // else from those that the mesh is all around: light arrives at others, outside of it
};

/// Follows a few thousand short paths from the points to sun and sky, and a few hundred from each lamp to the points.
/// A light that any of them connects is not listed, nor is a lamp outside of the points' bounds.
///
/// A mesh is named for sun or sky where the rest of the level is within its bounds, where it stops every ray towards
/// the light (of a sky: every ray upwards) from the points that it is all around, a sixteenth of all at least, and
/// where it is the only thing that stops some: without it, light would arrive. Points outside of it, as in the corners
/// round a dome, may be lit. It is named for a lamp where it stops every ray from the lamp.
///
/// points  where light is gathered, relative to Scene::origin
/// A sun or sky that several meshes together keep out, as walls and roof of a house do, is not listed.
[[nodiscard]] std::vector<ShutOut> find_shut_out(const PathTracer& paths, std::span<const glm::vec3> points);

/// Whether every light of the level is kept out by one mesh or another: what light there is, is not the level's.
[[nodiscard]] bool is_all_shut_out(const PathTracer& paths, std::span<const ShutOut> shut_out);

}  // namespace lightgrid
