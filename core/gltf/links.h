#pragma once

#include "core/gltf/finding.h"

#include <span>

namespace tinygltf {
class Model;
}

namespace lightgrid::gltf {

struct BufferSource;
struct ImageSource;

/// Checks how the things of a parsed document fit together: views in buffers, accessors in views, what primitives,
/// skins and nodes ask of accessors. Only what the document says is looked at, no data.
[[nodiscard]] Findings check_links(const tinygltf::Model& model, std::span<const BufferSource> buffers,
                                   std::span<const ImageSource> images);

}  // namespace lightgrid::gltf
