#pragma once

#include "tools/pictures.h"

#include <glm/glm.hpp>
#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <vector>

namespace lightgrid {

/// Where the page's slices go through: the worst held-out point; where the error was not measured, the middle of the
/// volume.
[[nodiscard]] glm::dvec3 slice_point(const nlohmann::json& report, const Volume& volume);

/// A bake's report as one HTML page that needs nothing else: no script, no network, pictures and plots inside. Behind
/// every plot stands its table. All text of the report is escaped.
///
/// report  of level-bake --report-json
/// slices  none: there is nothing to slice
[[nodiscard]] std::string report_page(const nlohmann::json& report, const std::optional<SlicePictures>& slices);

}  // namespace lightgrid
