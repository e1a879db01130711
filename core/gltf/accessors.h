#pragma once

#include "core/gltf/document.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace lightgrid::gltf {

/// 1, 2 or 4.
[[nodiscard]] std::size_t component_bytes(int component_type);
/// Of one element; each column of a matrix begins at a multiple of 4 bytes.
[[nodiscard]] std::size_t element_bytes(int type, int component_type);
/// Bytes from one element to the next.
[[nodiscard]] std::size_t stride_of(const tinygltf::Accessor& accessor, const tinygltf::BufferView& view);

/// The elements of an accessor where they lie in the file, not yet converted.
struct Elements {
    std::string where;      // `POSITION (accessor 7)`
    Bytes data;             // from the first element on; empty: all are zero
    std::size_t count = 0;  // all of them are in `data`
    std::size_t stride = 0;
    int component_type = 0;
    int components = 0;  // of one element; 16 for MAT4
    bool normalized = false;
    std::vector<std::uint32_t> replaced;  // sparse: elements that have other values; strictly increasing
    Bytes replacements;                   // sparse: those values, tightly packed
};

/// name  for messages: "POSITION"
/// Throws Error: what was found wrong with the accessor, its view or its buffer, or sparse indices that are.
[[nodiscard]] Elements elements_of(const Document& document, int accessor, const std::string& name = {});

/// The elements to read: strictly increasing indices, each below the count; empty: all.
using Picks = std::span<const std::uint32_t>;

/// The picked elements as numbers, normalised integers as [0, 1] or [-1, 1]. Of N or more components the first N; N is
/// 2, 3, 4 or 16. Throws Error where one is not finite.
template <int N>
[[nodiscard]] std::vector<glm::vec<N, float>> read_vectors(const Elements& elements, Picks picks = {});
[[nodiscard]] std::vector<glm::dmat4> read_matrices(const Elements& elements);
/// Integers that are not normalised, widened.
[[nodiscard]] std::vector<std::uint32_t> read_indices(const Elements& elements);
[[nodiscard]] std::vector<glm::uvec4> read_joints(const Elements& elements, Picks picks = {});

}  // namespace lightgrid::gltf
