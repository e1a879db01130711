#pragma once

#include "core/image.h"

#include <cstddef>
#include <span>
#include <string>

namespace lightgrid {

[[nodiscard]] bool is_exr(std::span<const std::byte> bytes);

/// OpenEXR, see decode_radiance.
[[nodiscard]] RadianceFile decode_exr(std::span<const std::byte> bytes, const std::string& where,
                                      const std::string& layer = {});

/// R, G, B as float, ZIP-compressed scanlines.
[[nodiscard]] std::string encode_exr(const RadianceImage& image);

}  // namespace lightgrid
