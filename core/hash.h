#pragma once

#include "core/sampling.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace lightgrid {

/// A number that differs for other bytes, but for one chance in 2^64 or so; no defence against forgery. Words of eight
/// bytes are mixed into four numbers in turn, which do not wait for each other; the length counts.
///
/// key  another key gives other numbers: that of earlier bytes joins them
[[nodiscard]] inline std::uint64_t hash_bytes(std::span<const std::byte> bytes, std::uint64_t key = 0) noexcept {
    constexpr std::size_t word = sizeof(std::uint64_t);
    std::array<std::uint64_t, 4> hashes{mix_bits(key, bytes.size()), 1, 2, 3};
    const auto mix_in = [&](std::size_t lane, std::size_t at, std::size_t size) {
        std::uint64_t value = 0;
        std::memcpy(&value, bytes.data() + at, size);
        hashes[lane] = mix_bits(hashes[lane], value);
    };
    std::size_t i = 0;
    for (; i + hashes.size() * word <= bytes.size(); i += hashes.size() * word) {
        for (std::size_t lane = 0; lane < hashes.size(); ++lane) mix_in(lane, i + lane * word, word);
    }
    for (; i < bytes.size(); i += word) mix_in(0, i, std::min(word, bytes.size() - i));
    return mix_bits(mix_bits(mix_bits(hashes[0], hashes[1]), hashes[2]), hashes[3]);
}

}  // namespace lightgrid
