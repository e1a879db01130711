#pragma once

#include <cstdint>
#include <string>

namespace lightgrid {

/// What a bake ran on. Empty or 0 where the system does not tell.
struct Machine {
    std::string processor;
    int logical_processors = 0;
    std::uint64_t memory_bytes = 0;
    std::string system;      // distribution and kernel
    std::string built_with;  // compiler and kind of build
    std::string libraries;   // those that computed or wrote something, with versions
};
[[nodiscard]] Machine this_machine();

/// The most memory that this process has held at once so far.
[[nodiscard]] std::uint64_t peak_memory_bytes();

}  // namespace lightgrid
