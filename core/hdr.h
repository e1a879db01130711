#pragma once

#include "core/image.h"

#include <cstddef>
#include <span>
#include <string>

namespace lightgrid {

[[nodiscard]] bool is_hdr(std::span<const std::byte> bytes);

/// Radiance RGBE (.hdr, .pic), see decode_radiance. Source: Ward, "Real Pixels", Graphics Gems II, 1991, and "The
/// RADIANCE Picture File Format". Rows bottom-up or right to left are turned; pictures stored by columns, and XYZE, are
/// refused.
[[nodiscard]] RadianceFile decode_hdr(std::span<const std::byte> bytes, const std::string& where);

}  // namespace lightgrid
