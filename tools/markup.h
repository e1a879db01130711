#pragma once

#include <string>
#include <string_view>

/// Pieces of HTML and SVG text.
namespace lightgrid {

/// & < > " ' as entities: safe as text and inside of quoted attributes.
[[nodiscard]] std::string escape(std::string_view text);

/// RFC 4648, padded.
[[nodiscard]] std::string base64(std::string_view bytes);

/// 0.0421 as "4.21 %"; "0 %" and "< 0.001 %" at the small end.
[[nodiscard]] std::string percent_text(double share);
/// 65536 as "65,536".
[[nodiscard]] std::string grouped(unsigned long long number);

}  // namespace lightgrid
