#include "apps/bench/vision/bench.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "vision/plain_disc_bound.h"

namespace tribotrack::bench {

using namespace vision;

namespace {

TEST(VisionBench, QuickRunComparesEveryMethodOnBothGrounds) {
  VisionBenchOptions options;
  options.quick = true;
  int last = 0;
  options.progress = [&](int done, int total) {
    EXPECT_EQ(done, ++last);
    EXPECT_EQ(total, 2);
  };
  const auto rows = bench_vision(options);
  EXPECT_EQ(last, 2);
  std::map<std::string, std::map<std::string, VisionBenchRow>> found;
  for (const VisionBenchRow& row : rows) {
    found[row.scene][row.method] = row;
    EXPECT_EQ(row.lost, 0) << row.scene << " " << row.method;
    EXPECT_GT(row.time, 0);
    EXPECT_LT(row.rms, 0.5) << row.scene << " " << row.method;
    // 2 x 23 components: the rms is known to a tenth.
    EXPECT_GT(row.rms, 0.7 * row.bound) << "below the Cramer-Rao bound: " << row.method;
  }
  ASSERT_EQ(found.size(), 2u);
  const std::set<std::string> all{"tribotrack track",
                                  "tribotrack registration alone",
                                  "cv::matchTemplate + parabola",
                                  "cv::matchTemplate + Gaussian",
                                  "cv::phaseCorrelate",
                                  "grey centroid"};
  for (const auto& [scene, methods] : found) {
    std::set<std::string> names;
    for (const auto& [name, row] : methods) {
      names.insert(name);
      const VisionBenchRow& ours = methods.at("tribotrack track");
      EXPECT_DOUBLE_EQ(row.rms_over_ours, row.rms / ours.rms);
      EXPECT_DOUBLE_EQ(row.time_over_ours, row.time / ours.time);
    }
    EXPECT_EQ(names, all) << scene;
  }
  // (sigma / A) sqrt(2 s / (sqrt(pi) R)) on a plain platform.
  const VisionBenchRow& plain = found.at("plain").at("grey centroid");
  EXPECT_NEAR(
      plain.bound / test::plain_disc_bound(12, 90, std::sqrt(0.49 + 1.0 / 12), std::sqrt(4 + 1.0 / 12)), 1,
      0.02);
  // What a moving brushed ground does to a centroid is seen.
  EXPECT_GT(found.at("brushed, moving").at("grey centroid").rms, 3 * plain.rms);
}

}  // namespace
}  // namespace tribotrack::bench
