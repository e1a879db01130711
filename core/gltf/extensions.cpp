#include "core/gltf/extensions.h"

#include "core/error.h"

#include <fmt/format.h>

#include <set>

namespace lightgrid::gltf {
namespace {

/// Images of kinds that cannot be read: a texture that has no other is missing, which is said of it by name.
const std::set<std::string> images = {"EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds"};

const std::set<std::string> supported = {
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_diffuse_transmission",  // refused or noticed where a material that is used lets light through
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_transform",
};

/// They shape highlights, refraction, animation or data for other programs; every surface being Lambertian, they change
/// no light that is baked.
const std::set<std::string> without_effect = {
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "GODOT_single_root",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_audio_emitter",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_physics_rigid_bodies",
    "KHR_implicit_shapes",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic",
};

}  // namespace

void check_extensions(const Document& document, Notices& notices) {
    const auto known = [](const std::string& name) {
        return supported.contains(name) || without_effect.contains(name) || images.contains(name);
    };
    std::string missing;
    for (const std::string& name : document.model().extensionsRequired)
        if (!known(name)) missing += (missing.empty() ? "" : ", ") + name;
    if (!missing.empty())
        throw Error(fmt::format("the file requires {}, which cannot be read", missing), "",
                    "Export the level without it.");
    for (const std::string& name : document.model().extensionsUsed)
        if (!known(name)) notices.add(name, "the extension is not known, and what it adds is not in the light");
}

}  // namespace lightgrid::gltf
