#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// Names that differ by little: by case, or by what a hand mistypes.
namespace lightgrid {

/// Of the letters A to Z; the bytes of other letters stay as they are.
[[nodiscard]] std::string lower_case(std::string text);

/// Insertions, deletions, replacements and swaps of neighbours that turn a into b (optimal string alignment distance).
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// At most `count` of `known`, each once, those first that take the fewest edits; upper and lower case are the same.
[[nodiscard]] std::vector<std::string> nearest_names(const std::string& wrong, std::vector<std::string> known,
                                                     std::size_t count);

}  // namespace lightgrid
