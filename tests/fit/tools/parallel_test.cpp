#include "fit/tools/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace tribotrack::fit::internal {
namespace {

TEST(ParallelFor, DoesEachOnce) {
  for (const int threads : {1, 2, 5}) {
    std::vector<std::atomic<int>> done(100);
    parallel_for(done.size(), threads, [&](std::size_t i) { ++done[i]; });
    for (const auto& count : done) EXPECT_EQ(count, 1);
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
}  // namespace tribotrack::fit::internal
