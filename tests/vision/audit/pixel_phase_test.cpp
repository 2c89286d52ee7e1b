#include "vision/audit/frame_to_frame.h"

#include <gtest/gtest.h>

#include <numbers>

#include "vision/audit/synthetic_track.h"

namespace tribotrack::vision {
namespace {

using test::kSigma;
using test::track_of;
using test::white;

/// Decelerating, a quarter of a pixel a frame at first.
double slide(int k) {
  return 0.27 * k - 0.0003 * k * k;
}

TEST(PixelPhase, WithoutItTheRatioIsOne) {
  double mean = 0;
  int beyond = 0;
  constexpr int kTrials = 200;
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    const auto found =
        pixel_phase(stretches(track_of(300, seed, slide, [](int, std::mt19937& r) { return white(r); })),
                    kAlongX, LocalPolynomial(2), 1);
    ASSERT_TRUE(found);
    EXPECT_GE(found->value, 1);
    EXPECT_LT(found->value, 1.1);
    mean += found->value / kTrials;
    beyond += supported(*found) > 1;
  }
  EXPECT_LT(mean, 1.02);
  EXPECT_LE(beyond, 16);  // mean square of few numbers: a longer tail than a normal one
}

TEST(PixelPhase, AnErrorThatFollowsTheFractionIsFoundWithItsSize) {
  Track track = track_of(
      1200, 2, [](int k) { return 0.27 * k; }, [](int, std::mt19937& r) { return white(r); });
  const double amplitude = 2 * kSigma;
  for (TrackPoint& p : track.points) {
    p.x += amplitude * std::sin(2 * std::numbers::pi * p.x);
    p.y += amplitude * std::sin(2 * std::numbers::pi * p.y);
  }
  const auto found = pixel_phase(stretches(track), kAlongX, LocalPolynomial(2), 1);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->value, 1 + 0.5 * std::pow(amplitude / kSigma, 2), 0.4);
  EXPECT_GT(supported(*found), 2.5);
}

TEST(PixelPhase, APartAtRestTellsNothing) {
  for (const double sigma : {kSigma, 5 * kSigma}) {
    Track track = track_of(
        600, 2, [](int) { return 0.3; }, [&](int, std::mt19937& r) { return white(r, sigma); });
    for (TrackPoint& p : track.points) p.sigma_x = p.sigma_y = sigma;
    EXPECT_FALSE(pixel_phase(stretches(track), kAlongX, LocalPolynomial(2), 1)) << sigma;
  }
}

}  // namespace
}  // namespace tribotrack::vision
