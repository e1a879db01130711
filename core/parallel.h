#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace lightgrid {

/// How many threads the library may use from now on, until the returned object dies. 0: all of the machine. Of several
/// limits alive at once the smallest counts.
class ThreadLimit {
  public:
    explicit ThreadLimit(int threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;

  private:
    struct Control;
    std::unique_ptr<Control> control_;
};

[[nodiscard]] int thread_count();

/// Calls body(i) for every i in [0, count), in any order, on all allowed threads, with denormals flushed to zero (as
/// Embree asks); the caller's own floating-point mode is what it was afterwards. An exception in a body stops the loop
/// and is thrown here.
void for_each_index(std::size_t count, const std::function<void(std::size_t)>& body);

}  // namespace lightgrid
