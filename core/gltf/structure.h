#pragma once

#include "core/gltf/finding.h"

#include <nlohmann/json_fwd.hpp>

namespace lightgrid::gltf {

/// Checks a document against the structure that glTF 2.0 and its extensions prescribe (types, ranges, references) and
/// leaves in it only what is well-formed and what light paths may read. So whatever reads it afterwards needs no checks
/// of its own: tinygltf takes wrong types for absent ones, reads every image, refuses legal accessors without data, and
/// trusts references.
///
/// What a thing cannot do without is filled in where it is missing; the finding keeps it from being read.
///
/// Throws Error where the file as a whole cannot be read: no object, another version of glTF.
[[nodiscard]] Findings check_structure(nlohmann::json& document);

}  // namespace lightgrid::gltf
