#pragma once

#include "core/gltf/finding.h"

#include <span>

namespace tinygltf {
class Model;
}

namespace lightgrid::gltf {

struct BufferSource;

/// Checks how the things of a parsed document fit together: views in buffers, accessors in views, what primitives,
/// skins and nodes ask of accessors. Only what the document says is looked at, no data.
[[nodiscard]] Findings check_links(const tinygltf::Model& model, std::span<const BufferSource> buffers);

}  // namespace lightgrid::gltf
