#pragma once

#include "core/gltf/document.h"

namespace lightgrid::gltf {

/// Throws Error naming the extensions that the file requires and nothing here knows. Those that it only uses are
/// noticed, unless they are known to change no light.
void check_extensions(const Document& document, Notices& notices);

}  // namespace lightgrid::gltf
