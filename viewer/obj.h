#pragma once

#include "core/scene.h"

#include <filesystem>

namespace lightgrid {

/// Reads a Wavefront OBJ file, and the MTL files and pictures that it names beside it. Polygons become triangles;
/// lines, points, groups and the file's normals are left out. Of a material: Kd and map_Kd (albedo), Ke and map_Ke
/// (emission, cd/m^2), d (alpha). Colours behind a vertex's position (`v x y z r g b`) are linear.
///
/// Throws Error (Fault::input) for a file that is none, or has no triangle with an area. What is missing beside it, a
/// material file or a picture, is named in Scene::notices.
[[nodiscard]] Scene load_obj(const std::filesystem::path& path);

}  // namespace lightgrid
