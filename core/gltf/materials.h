#pragma once

#include "core/gltf/document.h"
#include "core/scene.h"

#include <vector>

namespace lightgrid::gltf {

/// Which materials the primitives of a level have: by their index in the file; no_material is the one of primitives
/// that name none.
inline constexpr int no_material = -1;

/// Fills scene.materials with the materials that are used, and scene.textures with what light reads of them, decoded on
/// all threads. Textures with the same image and sampler are one.
///
/// used     by index in the file plus one
/// returns  the index in scene.materials for each, the same way; -1 where unused
[[nodiscard]] std::vector<int> load_materials(const Document& document, const std::vector<bool>& used, Scene& scene,
                                              Notices& notices);

}  // namespace lightgrid::gltf
