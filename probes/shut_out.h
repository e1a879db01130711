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
    std::string light;  // `the light "Sun"`, `the sky`
    std::string mesh;  // name of the node (Scene::node_names) that is in its way; empty: no one mesh is, or it has none
};

/// Follows a few thousand short paths from the points to sun and sky, and a few hundred from each lamp to the points.
/// A light that any of them connects is not listed, nor is a lamp outside of the points' bounds.
///
/// A mesh is named for sun or sky where it encloses all points, stops every ray from them towards the light (of a sky:
/// every ray upwards), and is the only thing that stops some: without it, light would arrive. It is named for a lamp
/// where it stops every ray from the lamp.
///
/// points  where light is gathered, relative to Scene::origin
/// A sun or sky that several meshes together keep out, as walls and roof of a house do, is not listed.
[[nodiscard]] std::vector<ShutOut> find_shut_out(const PathTracer& paths, std::span<const glm::vec3> points);

}  // namespace lightgrid
