#pragma once

#include "core/gltf/document.h"
#include "core/scene.h"

#include <string>
#include <vector>

namespace lightgrid::gltf {

/// Where the materials of a file are in Scene::materials.
struct LoadedMaterials {
    std::vector<int> indices;        // by index in the file plus one; the first is that of primitives that name none
    std::vector<std::string> names;  // for people, by index in Scene::materials: `material "brick"`

    /// -1 stands for none.
    [[nodiscard]] static std::size_t slot_of(int material) {
        return material < 0 ? 0 : static_cast<std::size_t>(material) + 1;
    }
    [[nodiscard]] int index_of(int material) const { return indices[slot_of(material)]; }
};

/// Fills scene.materials with the materials that are used, and scene.textures with what light reads of them, decoded on
/// all threads. Textures with the same image and sampler are one.
///
/// used  by index in the file plus one
/// Throws Error.
[[nodiscard]] LoadedMaterials load_materials(const Document& document, const std::vector<bool>& used, Scene& scene,
                                             Notices& notices);

}  // namespace lightgrid::gltf
