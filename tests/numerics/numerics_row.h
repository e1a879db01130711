#pragma once

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <string>

namespace lightgrid {

/// Prints one line of the table of numerics on standard output and fails the running test if the error is too large:
///
///   numerics | case | exact | ours | error | verdict | naive
///
/// exact  the closed form or reference value         naive  what a textbook implementation gives, or "-"
/// error  of ours, as the case's name says; NaN fails
inline void numerics_row(const std::string& name, double exact, double ours, double error, double tolerance,
                         const std::string& naive = "-") {
    const bool good = error <= tolerance;
    fmt::print("numerics | {} | {:.10g} | {:.10g} | {:.2g} | {} | {}\n", name, exact, ours, error, good ? "ok" : "FAIL",
               naive);
    EXPECT_LE(error, tolerance) << name;
}

}  // namespace lightgrid
