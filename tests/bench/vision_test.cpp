// How close to the physical limit the tracker is, and how true its standard deviations.
#include "apps/bench/vision.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>

#include "vision/plain_disc_bound.h"

namespace tribotrack::bench {

namespace {

/// More than 2000 error components on a scene of the analytic renderer: ground that the part never uncovers,
/// its texture twenty times the noise.
TEST(VisionBench, BrushedPlatformIsTrackedNearTheBoundWithTrueErrors) {
  VisionBenchOptions options;
  options.radii = {30};
  options.textures = {20};
  options.noises = {1};
  const ComparedRow row = bench_vision(options).rows.front();
  std::printf("rms / bound %.3f, standardised %.3f\n", row.error, row.at("standardised"));
  EXPECT_TRUE(row.ours);
  EXPECT_TRUE(row.at("layered"));
  EXPECT_EQ(row.at("lost"), 0);
  EXPECT_GE(row.at("components"), 2000);
  // 2098 components: their rms is known to 1.5 %, so a standard deviation that is true lies within three
  // such, and no estimate is better than the bound by more.
  EXPECT_GT(row.error, 0.95);
  EXPECT_LT(row.error, 1.15);
  EXPECT_GT(row.at("standardised"), 0.92);
  EXPECT_LT(row.at("standardised"), 1.05);
}

TEST(VisionBench, QuickRunComparesEveryMethodOnBothGrounds) {
  int last = 0;
  VisionBenchOptions options = quick_vision_options();
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
