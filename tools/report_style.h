#pragma once

#include <string_view>

namespace lightgrid {

/// report.css, as it was when the program was built.
[[nodiscard]] std::string_view report_style();

}  // namespace lightgrid
