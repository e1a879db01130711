#pragma once

#include "core/gltf.h"
#include "core/gltf/document.h"
#include "core/scene.h"

#include <compare>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace lightgrid::gltf {

/// Whether it emits, textures aside. -1: the material of primitives that name none.
[[nodiscard]] bool material_emits(const Document& document, int material);

/// A material as the level uses it: one that emits is another in every group of lights.
struct MaterialUse {
    int material = -1;  // index in the file; -1: of primitives that name none
    int group = -1;     // -1 where it does not emit
    auto operator<=>(const MaterialUse&) const = default;
};
[[nodiscard]] MaterialUse material_use(const Document& document, int material, int group);

/// Where the materials of a file are in Scene::materials.
struct LoadedMaterials {
    std::map<MaterialUse, int> indices;
    std::vector<std::string> names;  // for people, by index in Scene::materials: `material "brick"`
};

/// Fills scene.materials with the materials that are used, and scene.textures with what light reads of them, decoded on
/// all threads. Textures with the same image and sampler are one. What has become of missing textures and of a level
/// without materials is as load_level says.
///
/// Throws Error.
[[nodiscard]] LoadedMaterials load_materials(const Document& document, const std::set<MaterialUse>& used,
                                             const LoadOptions& options, Scene& scene, Notices& notices);

}  // namespace lightgrid::gltf
