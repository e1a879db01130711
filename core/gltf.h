#pragma once

#include "core/scene.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace lightgrid {

enum class MissingTextures : std::uint8_t { warn, error };

struct LoadOptions {
    int scene = -1;  // index of the glTF scene; -1: the file's default, else the first
    // Patterns as shells know them (*, ?, [a-z]) of nodes to leave out with all below them: of a node's name, or of its
    // mesh's where it has none. One that fits no node is an Error that names the nearest.
    std::vector<std::string> ignore;
    float default_albedo = 0.8F;  // of a level none of whose primitives has a material, in [0, 1]
    // What becomes of textures that are missing or cannot be read: named and left out, or an Error.
    MissingTextures missing_textures = MissingTextures::warn;
    double metres_per_unit = 1;  // > 0; glTF's unit is the metre, but not every exporter's is
};

/// Reads a level from glTF 2.0: .gltf or .glb, recognised by content, with data URIs or files beside it.
///
/// Nodes       transforms compose in double; a negative determinant turns the winding, so that front stays front. A
///             mesh that stands several times becomes instances, never copies: by several nodes or by
///             EXT_mesh_gpu_instancing.
/// Left out    nodes with extras {"lightgrid": "ignore"} or a name that LoadOptions::ignore fits, and all below them.
/// Hidden      nodes that KHR_node_visibility hides, themselves or by a parent, and nodes whose three axes are scaled to
///             nothing: neither their meshes nor their lights are part of the level. Skins follow their joints, and
///             markers count also where they are hidden.
/// Geometry    every triangle mode, indexed or not; sparse, interleaved, quantised (KHR_mesh_quantization), packed
///             (EXT_meshopt_compression, KHR_meshopt_compression, KHR_draco_mesh_compression); skins and morph targets as they stand at rest.
///             Points and lines are no part of the level; triangles without area are dropped.
/// Materials   base colour, alpha, transmission, emission (KHR_materials_emissive_strength), any UV set,
///             KHR_texture_transform, EXT_texture_webp; diffuse of KHR_materials_pbrSpecularGlossiness where there is
///             no base colour. Where no primitive has a material, LoadOptions::default_albedo in place of glTF's white,
///             in which light hardly dies away; vertex colours multiply it.
/// Textures    of a missing or unreadable one (damaged, KTX2, DDS, AVIF) the factor stands for base colour and for
///             transmission, emission is dark, alpha opaque; Scene::missing_textures names it, and a notice.
/// Lights      KHR_lights_punctual.
/// Markers     nodes with extras {"lightgrid": "volume"} or {"lightgrid": "probe"}; their meshes are no part of the
///             level.
/// Groups      nodes with extras {"lightgrid": {"group": "NAME"}}: lights and emissive meshes there and below belong to
///             it, but for those that are nearer to another group's node.
///
/// Only what light paths read is converted, and what turns out to make no difference is left out (Scene::left_out).
/// What was ignored, clamped or repaired, and what is broken where no light path reads it, is named in Scene::notices.
///
/// Throws Error (Fault::input) naming file and place for anything broken or unknown that would change the light: also
/// for extensions that the file requires and nothing here knows. The level is the same whatever
/// the number of threads.
[[nodiscard]] Scene load_level(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace lightgrid
