#pragma once

#include "core/gltf/document.h"

#include <map>
#include <string>
#include <vector>

namespace lightgrid::gltf {

/// Unpacks a buffer view by EXT_meshopt_compression or KHR_meshopt_compression, as far as the library can that is built
/// in: attributes of version 1 take meshoptimizer 0.23. `size`: bytes of the view once unpacked, checked to be count times
/// stride. Throws Error.
[[nodiscard]] OwnedBytes unpack_meshopt(Bytes packed, const tinygltf::Value& extension, std::size_t size);

/// A primitive unpacked from KHR_draco_mesh_compression.
struct DracoMesh {
    struct Attribute {
        OwnedBytes data;  // tightly packed, vertex by vertex
        int component_type = 0;
        int components = 0;
    };
    std::size_t vertex_count = 0;
    std::vector<std::uint32_t> indices;           // three a triangle
    std::map<std::string, Attribute> attributes;  // those asked for
};

/// wanted  glTF's attribute names and the stream's own numbers for them
/// Throws Error.
[[nodiscard]] DracoMesh unpack_draco(Bytes packed, const std::map<std::string, int>& wanted);

}  // namespace lightgrid::gltf
