#pragma once

#include "core/gltf/finding.h"

#include <span>

namespace tinygltf {
class Model;
}

namespace lightgrid::gltf {

struct BufferSource;
struct ImageSource;

/// Adds to `findings` what check_structure could not see: how the things of a document fit together: views in buffers,
/// accessors in views, what primitives, skins and nodes ask of accessors. Only what the document says is looked at, no
/// data. What has a finding already gets no second one for what follows from it.
void check_links(const tinygltf::Model& model, std::span<const BufferSource> buffers,
                 std::span<const ImageSource> images, Findings& findings);

}  // namespace lightgrid::gltf
