#include "vision/audit/audit.h"

#include <gtest/gtest.h>

#include "vision/audit/synthetic_track.h"

namespace tribotrack::vision {
namespace {

using test::track_of;
using test::white;

auto noise() {
  return [](int, std::mt19937& random) { return white(random); };
}

double at_rest(int) {
  return 0;
}

std::vector<TrackStretch> along_x(const Track& track) {
  return stretches(track, &TrackPoint::x, &TrackPoint::sigma_x);
}

TEST(HighFrequency, WhiteNoiseIsFoundByTheLowestOrderAndItsScatterIsTrue) {
  double mean = 0, spread = 0, claimed = 0;
  int low = 0, silent = 0;
  constexpr int kTrials = 200;
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    const auto found = high_frequency(along_x(track_of(200, seed, at_rest, noise())));
    silent += !found;
    if (!found) continue;
    mean += found->noise.value / kTrials;
    spread += std::pow(found->noise.value - 1, 2) / kTrials;
    claimed += found->noise.scatter / kTrials;
    low += found->order == 2;
  }
  EXPECT_NEAR(mean, 1, 0.02);
  EXPECT_NEAR(claimed / std::sqrt(spread), 1, 0.2);
  // Three standard deviations of skewed estimates: one in a hundred is taken for a motion.
  EXPECT_LE(silent, 2);
  EXPECT_GE(low, 190);
}

/// On a platform at 10 Hz filmed at 1000 frames/s second differences see the motion, fourth do not.
TEST(HighFrequency, AMotionThatLowOrdersSeeTakesAHigherOne) {
  const auto circle = [](int k) { return 15 * std::cos(0.0628 * k); };
  const auto found = high_frequency(along_x(track_of(600, 1, circle, noise())));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->order, 4);
  EXPECT_NEAR(found->noise.value, 1, 0.15);
}

TEST(HighFrequency, AMotionThatIsFastAgainstTheFrameRateSaysNothing) {
  const auto circle = [](int k) { return 15 * std::cos(0.9 * k); };
  EXPECT_FALSE(high_frequency(along_x(track_of(600, 1, circle, noise()))));
}

TEST(HighFrequency, SingleOutliersAndGapsDoNotMatter) {
  Track track = track_of(
      600, 1, [](int k) { return 0.3 * k; }, noise());
  track.points[100].x += 3;
  track.points[400].y -= 3;
  for (std::size_t k = 200; k < 210; ++k) track.points[k].status = TrackStatus::lost;
  for (std::size_t k = 210; k < 600; ++k) track.points[k].x += 50;
  EXPECT_NEAR(high_frequency(along_x(track))->noise.value, 1, 0.2);
  EXPECT_NEAR(high_frequency(stretches(track, &TrackPoint::y, &TrackPoint::sigma_y))->noise.value, 1, 0.2);
}

}  // namespace
}  // namespace tribotrack::vision
