#include "model/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>

namespace tribotrack {
namespace {

// Loops within loops, and one after them, use no more threads than were asked for.
TEST(ParallelFor, SharesItsThreadsWithLoopsInside) {
  for (const std::size_t outer : {2u, 3u, 7u}) {
    std::atomic<int> at_work = 0, most = 0, done = 0;
    parallel_for(outer, 4, [&](std::size_t) {
      parallel_for(20, 4, [&](std::size_t) {
        const int now = ++at_work;
        for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        --at_work;
        ++done;
      });
    });
    EXPECT_LE(most, 4) << outer;
    EXPECT_EQ(done, static_cast<int>(20 * outer));
    EXPECT_EQ(threads_allowed(), std::numeric_limits<int>::max());
  }
}

TEST(ParallelFor, BeginsNothingMoreAfterAnException) {
  for (const int threads : {1, 2}) {
    std::atomic<int> begun = 0;
    const auto fail = [&](std::size_t) {
      ++begun;
      throw std::runtime_error("stop");
    };
    EXPECT_THROW(parallel_for(100000, threads, fail), std::runtime_error);
    EXPECT_LE(begun, threads);
  }
}

}  // namespace
}  // namespace tribotrack
