#include "core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace lightgrid {
namespace {

/// Flush-to-zero and denormals-are-zero on this thread while it lives.
class FlushDenormals {
  public:
#if defined(__SSE__)
    FlushDenormals() : saved_(_mm_getcsr()) {
        _mm_setcsr(saved_ | flush_to_zero | denormals_are_zero);
    }
    ~FlushDenormals() {
        _mm_setcsr(saved_);
    }
#else
    FlushDenormals() = default;
#endif
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;

  private:
#if defined(__SSE__)
    static constexpr unsigned flush_to_zero = 1U << 15;  // MXCSR, Intel SDM volume 1, 10.2.3
    static constexpr unsigned denormals_are_zero = 1U << 6;
    unsigned saved_;
#endif
};

}  // namespace

struct ThreadLimit::Control {
    tbb::global_control parallelism;
};

ThreadLimit::ThreadLimit(int threads)
    : control_(threads > 0 ? new Control{tbb::global_control(tbb::global_control::max_allowed_parallelism,
                                                             static_cast<std::size_t>(threads))}
                           : nullptr) {}

ThreadLimit::~ThreadLimit() = default;

int thread_count() {
    const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    return std::min(static_cast<int>(allowed), tbb::this_task_arena::max_concurrency());
}

void for_each_index(std::size_t count, const std::function<void(std::size_t)>& body) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count), [&body](const tbb::blocked_range<std::size_t>& range) {
        const FlushDenormals flush;
        for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
    });
}

}  // namespace lightgrid
