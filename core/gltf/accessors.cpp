#include "core/gltf/accessors.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace lightgrid::gltf {
namespace {

constexpr std::size_t most_zeros = std::size_t{1} << 24;  // of an accessor that has no data to back its count

template <typename T>
float to_float(T value, bool normalized) {
    if constexpr (std::is_floating_point_v<T>)
        return value;
    else
        return normalized
                   ? std::max(static_cast<float>(value) / static_cast<float>(std::numeric_limits<T>::max()), -1.0F)
                   : static_cast<float>(value);
}

/// Converts `count` elements of N components each, the i-th of them at data + stride * which(i).
template <typename T, int N, typename Which>
void convert(const std::byte* data, std::size_t stride, std::size_t count, bool normalized, Which which, float* out) {
    for (std::size_t i = 0; i < count; ++i) {
        T element[N];
        std::memcpy(element, data + stride * which(i), sizeof(element));
        for (int c = 0; c < N; ++c) out[i * N + static_cast<std::size_t>(c)] = to_float(element[c], normalized);
    }
}

template <int N, typename Which>
void convert(const Elements& elements, const std::byte* data, std::size_t stride, std::size_t count, Which which,
             float* out) {
    const bool normalized = elements.normalized;
    switch (elements.component_type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return convert<std::int8_t, N>(data, stride, count, normalized, which, out);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return convert<std::uint8_t, N>(data, stride, count, normalized, which, out);
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return convert<std::int16_t, N>(data, stride, count, normalized, which, out);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return convert<std::uint16_t, N>(data, stride, count, normalized, which, out);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return convert<std::uint32_t, N>(data, stride, count, normalized, which, out);
        default:
            return convert<float, N>(data, stride, count, normalized, which, out);
    }
}

void check_finite(const Elements& elements, Picks picks, std::span<const float> numbers, std::size_t components) {
    if (elements.component_type != TINYGLTF_COMPONENT_TYPE_FLOAT) return;
    constexpr std::uint32_t exponent = 0x7F800000;  // all ones: infinite or no number
    bool all_finite = true;
    for (const float number : numbers) all_finite &= (std::bit_cast<std::uint32_t>(number) & exponent) != exponent;
    if (all_finite) return;
    const auto bad =
        std::find_if_not(numbers.begin(), numbers.end(), [](float number) { return std::isfinite(number); });
    const std::size_t element = static_cast<std::size_t>(bad - numbers.begin()) / components;
    throw Error(fmt::format("element {} holds {}", picks.empty() ? element : picks[element], *bad), elements.where,
                "Every number must be finite: export the mesh again.");
}

template <typename T>
std::vector<std::uint32_t> widened(Bytes data, std::size_t stride, std::size_t count) {
    std::vector<std::uint32_t> result(count);
    for (std::size_t i = 0; i < count; ++i) {
        T value;
        std::memcpy(&value, data.data() + i * stride, sizeof(value));
        result[i] = value;
    }
    return result;
}

std::vector<std::uint32_t> widened(Bytes data, std::size_t stride, std::size_t count, int component_type) {
    switch (component_type) {
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return widened<std::uint8_t>(data, stride, count);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return widened<std::uint16_t>(data, stride, count);
        default:
            return widened<std::uint32_t>(data, stride, count);
    }
}

}  // namespace

std::size_t component_bytes(int component_type) {
    return static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(component_type)));
}

std::size_t element_bytes(int type, int component_type) {
    const std::size_t component = component_bytes(component_type);
    const auto padded = [](std::size_t column) { return (column + 3) / 4 * 4; };
    switch (type) {
        case TINYGLTF_TYPE_MAT2:
            return 2 * padded(2 * component);
        case TINYGLTF_TYPE_MAT3:
            return 3 * padded(3 * component);
        default:
            return component *
                   static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type)));
    }
}

std::size_t stride_of(const tinygltf::Accessor& accessor, const tinygltf::BufferView& view) {
    return view.byteStride != 0 ? view.byteStride : element_bytes(accessor.type, accessor.componentType);
}

Elements elements_of(const Document& document, int index, const std::string& name) {
    const tinygltf::Accessor& accessor = document.accessor(index);
    Elements elements;
    elements.where = name.empty() ? fmt::format("accessor {}", index) : fmt::format("{} (accessor {})", name, index);
    elements.count = accessor.count;
    elements.component_type = accessor.componentType;
    elements.components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
    elements.normalized = accessor.normalized;
    const tinygltf::BufferView& view = document.view(accessor.bufferView);
    elements.stride = stride_of(accessor, view);
    if (view.buffer >= 0)
        elements.data = document.bytes(accessor.bufferView).subspan(accessor.byteOffset);
    else if (accessor.count > most_zeros)
        throw Error(fmt::format("has {} elements without data", accessor.count), elements.where,
                    "Export the level again.");
    if (!accessor.sparse.isSparse) return elements;

    const auto& sparse = accessor.sparse;
    const auto count = static_cast<std::size_t>(sparse.count);
    const Bytes indices =
        document.bytes(sparse.indices.bufferView).subspan(static_cast<std::size_t>(sparse.indices.byteOffset));
    elements.replaced =
        widened(indices, component_bytes(sparse.indices.componentType), count, sparse.indices.componentType);
    for (std::size_t i = 0; i < count; ++i)
        if (elements.replaced[i] >= accessor.count || (i > 0 && elements.replaced[i] <= elements.replaced[i - 1]))
            throw Error(fmt::format("sparse index {} is {}, but indices must grow and stay below {}", i,
                                    elements.replaced[i], accessor.count),
                        elements.where, "Export the mesh again.");
    elements.replacements =
        document.bytes(sparse.values.bufferView).subspan(static_cast<std::size_t>(sparse.values.byteOffset));
    return elements;
}

template <int N>
std::vector<glm::vec<N, float>> read_vectors(const Elements& elements, Picks picks) {
    static_assert(sizeof(glm::vec<N, float>) == N * sizeof(float));
    const std::size_t count = picks.empty() ? elements.count : picks.size();
    std::vector<glm::vec<N, float>> result(count, glm::vec<N, float>(0));
    float* out = reinterpret_cast<float*>(result.data());
    if (!elements.data.empty()) {
        if (picks.empty())
            convert<N>(
                elements, elements.data.data(), elements.stride, count, [](std::size_t i) { return i; }, out);
        else
            convert<N>(
                elements, elements.data.data(), elements.stride, count, [&](std::size_t i) { return picks[i]; }, out);
    }
    if (!elements.replaced.empty()) {
        std::vector<float> values(elements.replaced.size() * N);
        convert<N>(
            elements, elements.replacements.data(),
            component_bytes(elements.component_type) * static_cast<std::size_t>(elements.components),
            elements.replaced.size(), [](std::size_t i) { return i; }, values.data());
        for (std::size_t i = 0; i < elements.replaced.size(); ++i) {
            std::size_t place = elements.replaced[i];
            if (!picks.empty()) {
                const auto found = std::lower_bound(picks.begin(), picks.end(), elements.replaced[i]);
                if (found == picks.end() || *found != elements.replaced[i]) continue;
                place = static_cast<std::size_t>(found - picks.begin());
            }
            std::copy_n(values.data() + i * N, N, out + place * N);
        }
    }
    check_finite(elements, picks, {out, count * N}, N);
    return result;
}

template std::vector<glm::vec2> read_vectors<2>(const Elements&, Picks);
template std::vector<glm::vec3> read_vectors<3>(const Elements&, Picks);
template std::vector<glm::vec4> read_vectors<4>(const Elements&, Picks);

std::vector<glm::dmat4> read_matrices(const Elements& elements) {
    std::vector<float> numbers(elements.count * 16);
    if (!elements.data.empty())
        convert<16>(
            elements, elements.data.data(), elements.stride, elements.count, [](std::size_t i) { return i; },
            numbers.data());
    check_finite(elements, {}, numbers, 16);
    std::vector<glm::dmat4> result(elements.count);
    for (std::size_t i = 0; i < elements.count; ++i)
        for (int k = 0; k < 16; ++k) result[i][k / 4][k % 4] = numbers[i * 16 + static_cast<std::size_t>(k)];
    return result;
}

std::vector<std::uint32_t> read_indices(const Elements& elements) {
    std::vector<std::uint32_t> result =
        elements.data.empty() ? std::vector<std::uint32_t>(elements.count)
                              : widened(elements.data, elements.stride, elements.count, elements.component_type);
    if (!elements.replaced.empty()) {
        const std::vector<std::uint32_t> values =
            widened(elements.replacements, component_bytes(elements.component_type), elements.replaced.size(),
                    elements.component_type);
        for (std::size_t i = 0; i < values.size(); ++i) result[elements.replaced[i]] = values[i];
    }
    return result;
}

std::vector<glm::uvec4> read_joints(const Elements& elements, Picks picks) {
    const std::vector<glm::vec4> numbers = read_vectors<4>(elements, picks);  // at most 65535: exact
    return {numbers.begin(), numbers.end()};
}

}  // namespace lightgrid::gltf
