#include "vision/layers/layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tribotrack::vision {
namespace {

TEST(LearningFrames, FitIntoMemory) {
  SeenFrames frames(300);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    frames[k].index = static_cast<std::int64_t>(k);
    frames[k].centre = {30 + static_cast<double>(k) / 3, 45};
  }
  MemorySource source({Picture(1200, 1200)}, 500);
  FirstPassResult first;
  first.noise_variance = 0.1;
  first.total = 300;
  constexpr double kPad = QuinticSpline::kPad;
  double before = 129;
  for (const double reach : {30.0, 200.0, 300.0, 500.0}) {
    const LearningFrames learning(source, frames, first, reach);
    // A window and its spline, and the ground's pictures. Sixteen windows are kept whatever they take.
    const double window = 4 * (std::pow(2 * reach + 1, 2) + std::pow(2 * reach + 1 + 2 * kPad, 2));
    const double ground = 40.0 * learning.region().width * learning.region().height;
    const auto count = static_cast<double>(learning.count());
    EXPECT_LE(count, before);
    EXPECT_LT(count * window + ground, reach < 400 ? 140e6 : 220e6);
    EXPECT_GE(count, 16);
    if (count < 128 && count > 16) {
      EXPECT_GT((count + 2) * window + ground, 140e6);
    }
    before = count;
  }
  EXPECT_EQ(before, 16);
}

}  // namespace
}  // namespace tribotrack::vision
