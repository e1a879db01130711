#include "core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace lightgrid {
namespace {

TEST(ForEachIndex, VisitsEachIndexOnce) {
    std::vector<std::atomic<int>> visits(10007);
    for_each_index(visits.size(), [&](std::size_t i) { ++visits[i]; });
    for (std::size_t i = 0; i < visits.size(); ++i) EXPECT_EQ(visits[i], 1) << i;
    for_each_index(0, [](std::size_t) { FAIL(); });
}

TEST(ForEachIndex, ThrowsWhatABodyThrows) {
    EXPECT_THROW(for_each_index(1000,
                                [](std::size_t i) {
                                    if (i == 500) throw std::runtime_error("500");
                                }),
                 std::runtime_error);
}

TEST(ForEachIndex, FlushesDenormalsAndLeavesTheCallerAsItWas) {
    const volatile float smallest_normal = 1.17549435e-38F;
    const float before = smallest_normal * 0.5F;
    EXPECT_GT(before, 0);
    std::atomic<int> kept{0};
    for_each_index(1000, [&](std::size_t) {
        const volatile float half = smallest_normal * 0.5F;
        if (half != 0) ++kept;
    });
    EXPECT_EQ(kept, 0);
    const volatile float after = smallest_normal * 0.5F;
    EXPECT_EQ(after, before);
}

TEST(ThreadLimit, BoundsTheThreadsWhileItLives) {
    const int all = thread_count();
    {
        const ThreadLimit limit(1);
        EXPECT_EQ(thread_count(), 1);
        std::set<std::thread::id> threads;
        for_each_index(1000, [&](std::size_t) { threads.insert(std::this_thread::get_id()); });
        EXPECT_EQ(threads.size(), 1U);
        const ThreadLimit no_limit(0);
        EXPECT_EQ(thread_count(), 1);
    }
    EXPECT_EQ(thread_count(), all);
}

}  // namespace
}  // namespace lightgrid
