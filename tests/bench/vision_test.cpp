// How close to the physical limit the tracker is, and how true its standard deviations.
#include "apps/bench/comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>

#include "vision/plain_disc_bound.h"

namespace tribotrack::bench {

namespace {

TEST(VisionBench, QuickRunComparesEveryMethodOnBothGrounds) {
  int last = 0;
  BenchOptions options{.quick = true};
  options.progress = [&](int done, int total) {
    EXPECT_EQ(done, ++last);
    EXPECT_EQ(total, 2);
  };
  std::map<std::string, std::map<std::string, ComparedRow>> found;
  for (const ComparedRow& row : bench_vision(options).rows) {
    found[row.group][row.method] = row;
    EXPECT_EQ(row.at("lost"), 0) << row.scene << " " << row.method;
    EXPECT_GT(row.time, 0);
    EXPECT_LT(row.at("rms_px"), 0.5) << row.scene << " " << row.method;
    EXPECT_GT(row.error, 0.9) << "below the Cramer-Rao bound: " << row.method;
  }
  ASSERT_EQ(found.size(), 2u);
  for (const auto& [group, methods] : found) EXPECT_EQ(methods.size(), 3u) << group;
  // (sigma / A) sqrt(2 s / (sqrt(pi) R)) on a plain platform.
  const double bound = found.at("plain platform").at("circle fit").at("bound_px");
  EXPECT_NEAR(
      bound / vision::test::plain_disc_bound(10, 90, std::sqrt(0.49 + 1.0 / 12), std::sqrt(9 + 1.0 / 12)), 1,
      0.02);
}

}  // namespace
}  // namespace tribotrack::bench
