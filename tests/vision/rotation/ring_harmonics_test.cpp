// Levels that are one harmonic of the angle about a centre: what the rings show is known exactly.
#include "vision/rotation/rotation_follower.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

namespace tribotrack::vision {
namespace {

constexpr int kOrder = 6;
constexpr double kAmplitude = 20;

/// 100 + 20 cos(6 (phi - theta)), phi counter-clockwise with y up.
Picture star(int side, const Point& centre, double theta) {
  Picture out(side, side);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double phi = std::atan2(centre.y - y, x - centre.x);
      out.row(y)[static_cast<std::size_t>(x)] =
          static_cast<float>(100 + kAmplitude * std::cos(kOrder * (phi - theta)));
    }
  return out;
}

void expect_star(double radius, double theta) {
  const Point centre{radius + 12.3, radius + 11.6};
  RingHarmonics rings(radius, 1);
  ASSERT_TRUE(rings.usable());
  const int side = 2 * static_cast<int>(radius) + 26;
  const Harmonics found = rings.of(star(side, centre, theta), centre);
  const auto expected = std::polar(0.5 * kAmplitude, -kOrder * theta);
  for (Eigen::Index ring = found.rings() / 2; ring < found.rings(); ++ring) {
    EXPECT_NEAR(std::abs(found(ring, kOrder) - expected), 0, 0.02 * kAmplitude) << ring;
    // An error of the centre would show in the neighbours.
    for (const Eigen::Index order : {kOrder - 1, kOrder + 1})
      EXPECT_NEAR(std::abs(found(ring, order)), 0, 0.003 * kAmplitude) << ring << ", order " << order;
  }
}

TEST(RingHarmonics, OfOneHarmonicAreThatOneWithItsPhase) {
  expect_star(30, 0);
  expect_star(30, 0.2);
}

TEST(RingHarmonics, OfALargeDiscAreAboutTheSameCentre) {
  expect_star(70, 0);      // two pixels in one
  expect_star(100, -0.1);  // three
}

}  // namespace
}  // namespace tribotrack::vision
