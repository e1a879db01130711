#pragma once

#include <algorithm>
#include <chrono>
#include <sys/resource.h>
#include <vector>

/// What the benchmarks share: clocks, and the spread of repeated measurements.
namespace lightgrid {

/// Time that a body took: on the wall, and of all the program's threads together, which other programs disturb less.
struct Seconds {
    double wall = 0;
    double processor = 0;
};

inline double processor_seconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

template <class Body>
Seconds seconds_of(Body&& body) {
    const double processor = processor_seconds();
    const auto start = std::chrono::steady_clock::now();
    body();
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
            processor_seconds() - processor};
}

struct Spread {
    double median, least, most;
};

/// values  at least one
inline Spread spread(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return {values[values.size() / 2], values.front(), values.back()};
}

}  // namespace lightgrid
