// What a coder does to the platform's motion, as measured.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "apps/measuring/measure_run.h"

namespace tribotrack::apps {
namespace {

constexpr double kW = 62.8, kA = 0.28e-3, kPhase = 1.1, kNoise = 1e-6;

TrackFile circling(std::optional<CodingFacts> coding) {
  TrackFile track;
  track.mm_per_px = 0.1;
  track.mm_per_px_sd = 0;
  track.facts.coding = std::move(coding);
  track.table.platform_frame = true;
  track.table.exposure = 1e-5;
  std::mt19937 random(3);
  std::normal_distribution<> noise(0, kNoise);
  for (int k = 0; k < 400; ++k) {
    const double t = 2e-3 * k, phase = kW * t + kPhase;
    track.table.frame.push_back(k);
    track.table.time.push_back(t);
    track.table.position.emplace_back(1e-3 * t, 0);
    track.table.covariance.push_back(kNoise * kNoise * Eigen::Matrix2d::Identity());
    track.table.marker.emplace_back(kA * std::cos(phase) + noise(random),
                                    -kA * std::sin(phase) + noise(random));
    track.table.marker_sigma.push_back(kNoise);
  }
  return track;
}

/// Nobody knows how much of it there was: the values stay, and all of it stands in their standard deviations.
TEST(CodedMotion, UnknownCoderIsCountedInFull) {
  CodingFacts facts;
  facts.coder = "h264";
  facts.mark_play_px = 0.05;
  const RunMeasurement plain = measure_run("plain", circling({}), {}),
                       coded = measure_run("coded", circling(facts), {});
  EXPECT_FALSE(plain.coded);
  ASSERT_TRUE(coded.coded);
  const double amplitude = std::max(plain.platform->amplitude.value, plain.platform->amplitude_y.value);
  const fit::SeenThroughPlay play = fit::seen_through_play(amplitude, 0.05 * 0.1e-3);
  EXPECT_DOUBLE_EQ(coded.coded->delay, play.delay);
  EXPECT_DOUBLE_EQ(coded.platform->phase_at_zero.value, plain.platform->phase_at_zero.value);
  EXPECT_NEAR(coded.platform->phase_at_zero.sd, std::hypot(plain.platform->phase_at_zero.sd, play.delay),
              1e-12);
  const double attenuation = std::max(play.attenuation, 0.5 * 0.05 * 0.1e-3 / amplitude);
  EXPECT_NEAR(coded.platform->amplitude.sd,
              std::hypot(plain.platform->amplitude.sd, attenuation * plain.platform->amplitude.value), 1e-15);
  EXPECT_EQ(coded.coded->exceeds,
            play.delay > 1.96 * plain.platform->phase_at_middle.sd ||
                attenuation * plain.platform->amplitude.value > 1.96 * plain.platform->amplitude.sd);
  EXPECT_TRUE(coded.coded->exceeds) << "0.02 rad against a phase known to 0.001";
  EXPECT_THAT(coded.warnings, testing::Contains(testing::HasSubstr("coder (h264)")));
}

}  // namespace
}  // namespace tribotrack::apps
