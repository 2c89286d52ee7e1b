#include "vision/kernels/bspline.h"

#include <gtest/gtest.h>

#include <random>

namespace tribotrack::vision {
namespace {

/// (x/8)^5 - 3 (x/8)^2 (y/8)^3 + y/8 about the middle: degree 5 in either direction and mixed.
double quintic(double x, double y) {
  const double u = x / 8;
  const double v = y / 8;
  return u * u * u * u * u - 3 * u * u * v * v * v + v;
}

TEST(QuinticSpline, ReproducesPolynomialsOfDegreeFive) {
  constexpr int kMiddle = 60;  // the border's mirror has died away: 0.43^40 < 1e-14
  Picture picture(2 * kMiddle + 1, 2 * kMiddle + 1);
  // Whole multiples of 2^-15 below 2^24 in size are exact in float once the far border is left flat.
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      picture.at(x, y) = static_cast<float>(quintic(x - kMiddle, y - kMiddle));
  const QuinticSpline spline(picture);
  for (double y = -6.3; y < 7; y += 1.17)
    for (double x = -6.8; x < 7; x += 0.93) {
      const SplineSample s = spline.sample(kMiddle + x, kMiddle + y);
      const double u = x / 8;
      const double v = y / 8;
      EXPECT_NEAR(s.value, quintic(x, y), 2e-5);
      EXPECT_NEAR(s.slope_x, (5 * u * u * u * u - 6 * u * v * v * v) / 8, 2e-5);
      EXPECT_NEAR(s.slope_y, (-9 * u * u * v * v + 1) / 8, 2e-5);
    }
}

TEST(QuinticSpline, PassesThroughEveryPixelUpToTheBorder) {
  std::mt19937 random(20);
  std::uniform_real_distribution<float> level(0, 255);
  for (const auto& [width, height] : {std::pair{17, 9}, {5, 40}, {3, 3}}) {
    Picture picture(width, height);
    for (float& l : picture.levels()) l = level(random);
    const QuinticSpline spline(picture);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) EXPECT_NEAR(spline.value(x, y), picture.at(x, y), 2e-4);
  }
}

TEST(QuinticSpline, WindowIsTheSameAsPlaceByPlace) {
  std::mt19937 random(21);
  std::uniform_real_distribution<float> level(0, 255);
  Picture picture(30, 22);
  for (float& l : picture.levels()) l = level(random);
  const QuinticSpline spline(picture);
  std::vector<float> v(12 * 9), sx(12 * 9), sy(12 * 9);
  for (const auto& [x0, y0] : {std::pair{4.0, 5.0}, {3.37, 6.81}, {-1.25, -2.5}, {17.9, 12.2}}) {
    spline.sample_window(x0, y0, 12, 9, v.data(), sx.data(), sy.data());
    for (int j = 0; j < 9; ++j)
      for (int i = 0; i < 12; ++i) {
        const SplineSample s = spline.sample(x0 + i, y0 + j);
        const auto k = static_cast<std::size_t>(j * 12 + i);
        EXPECT_NEAR(v[k], s.value, 2e-4);
        EXPECT_NEAR(sx[k], s.slope_x, 3e-4);
        EXPECT_NEAR(sy[k], s.slope_y, 3e-4);
      }
  }
}

TEST(QuinticSpline, NoiseGainMatchesInterpolatedWhiteNoise) {
  std::mt19937 random(22);
  std::normal_distribution<float> normal(0, 1);
  Picture noise(400, 400);
  for (float& l : noise.levels()) l = normal(random);
  const QuinticSpline spline(noise);
  constexpr int n = 380;
  std::vector<float> v(n * n), sx(n * n), sy(n * n);
  for (const auto& [fx, fy] : {std::pair{0.0, 0.0}, {0.5, 0.25}}) {
    spline.sample_window(10 + fx, 10 + fy, n, n, v.data(), sx.data(), sy.data());
    double value = 0;
    double slope = 0;
    for (std::size_t k = 0; k < v.size(); ++k) {
      value += static_cast<double>(v[k]) * v[k] / (n * n);
      slope += static_cast<double>(sx[k]) * sx[k] / (n * n);
    }
    const InterpolationNoise x = quintic_noise(fx);
    const InterpolationNoise y = quintic_noise(fy);
    EXPECT_NEAR(value / (x.value * y.value), 1, 0.02);
    EXPECT_NEAR(slope / (x.slope * y.value), 1, 0.02);
  }
  EXPECT_NEAR(quintic_noise(0).value, 1, 1e-6);  // coefficients are floats
}

TEST(QuinticSpline, NoiseCovarianceAgreesWithItselfAndItsDerivative) {
  constexpr double h = 1e-5;
  for (const double f : {0.0, 0.2, 0.5, 0.83}) {
    EXPECT_NEAR(quintic_noise(f, f).value, quintic_noise(f).value, 1e-12);
    // d/df of half the variance is the covariance of slope and value.
    const double slope = (quintic_noise(f + h).value - quintic_noise(f - h).value) / (4 * h);
    EXPECT_NEAR(quintic_noise(f, f).slope_value, slope, 1e-8);
    EXPECT_NEAR(quintic_noise(f, f - 1).value, 0, 0.3);
    EXPECT_NEAR(quintic_noise(f + 1, f + 1).slope_value, slope, 1e-8);
    // Whole pixels apart along a derivative: d/df <v(f) v(g)> = <v'(f) v(g)>.
    const double g = -0.4;
    const double mixed = (quintic_noise(f + h, g).value - quintic_noise(f - h, g).value) / (2 * h);
    EXPECT_NEAR(quintic_noise(f, g).slope_value, mixed, 1e-7);
  }
}

}  // namespace
}  // namespace tribotrack::vision
