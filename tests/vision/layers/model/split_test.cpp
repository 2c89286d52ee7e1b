#include "vision/layers/model/split.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "vision/kernels/bspline.h"

namespace tribotrack::vision {
namespace {

constexpr int kHalf = 24;
constexpr int kSize = 2 * kHalf + 1;

double lobe(double x, double y, double cx, double cy, double width) {
  return std::exp(-0.5 * ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (width * width));
}
double standing(double x, double y) {
  return 100 + 25 * lobe(x, y, -7, -7, 9);
}
double scratches(double x, double y) {
  return 12 * lobe(x, y, 6, 3, 1.3) - 9 * lobe(x, y, -4, 9, 1.5) + 10 * lobe(x, y, 2, -12, 1.4);
}
double seen(double x, double y, double theta) {
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  return standing(x, y) + scratches(c * x - s * y, s * x + c * y);
}

/// Predicts a rotation that was not among the pictures learnt from.
double worst_error(double span, int iterations) {
  std::vector<TurnedPicture> pictures;
  Picture cover(kSize, kSize);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) cover.at(x, y) = std::hypot(x - kHalf, y - kHalf) < 20 ? 1.0F : 0.0F;
  for (int k = 0; k <= 16; ++k) {
    TurnedPicture p{span * k / 16, Picture(kSize, kSize), Picture(kSize, kSize)};
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        p.level.at(x, y) = static_cast<float>(cover.at(x, y) * seen(x - kHalf, y - kHalf, p.theta));
        p.weight.at(x, y) = cover.at(x, y);
      }
    pictures.push_back(std::move(p));
  }
  StandingAndTurning parts{Picture(kSize, kSize), Picture(kSize, kSize), {}};
  split_turning(pictures, cover, 1e-3, 17, iterations, parts);
  const double theta = 0.47 * span;
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  const QuinticSpline turning(parts.turning);
  double worst = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double u = x - kHalf;
      const double v = y - kHalf;
      if (std::hypot(u, v) > 16) continue;
      const double predicted =
          parts.standing.at(x, y) + turning.value(kHalf + c * u - s * v, kHalf + s * u + c * v);
      worst = std::max(worst, std::abs(predicted - seen(u, v, theta)));
    }
  return worst;
}

TEST(SplitTurning, PredictsRotationsItHasNotSeen) {
  EXPECT_LT(worst_error(0.2, 60), 0.1);
  EXPECT_LT(worst_error(2.0, 60), 0.3);
}

TEST(SplitTurning, TurningRimHasNoFirstHarmonic) {
  // A rim that shifts in proportion to the rotation is taken for a moving disc, not for a turning picture.
  Picture cover(kSize, kSize);
  std::vector<TurnedPicture> pictures;
  for (int k = -6; k <= 6; ++k) {
    TurnedPicture p{0.02 * k, Picture(kSize, kSize), Picture(kSize, kSize, 1)};
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const double rho = std::hypot(x - kHalf - 0.02 * k, y - kHalf);
        cover.at(x, y) = std::hypot(x - kHalf, y - kHalf) < 21 ? 1.0F : 0.0F;
        p.level.at(x, y) = static_cast<float>(50 * std::erfc((rho - 18) / 1.2));
      }
    pictures.push_back(std::move(p));
  }
  StandingAndTurning parts{Picture(kSize, kSize), Picture(kSize, kSize), {}};
  split_turning(pictures, cover, 1e-3, 15, 60, parts);
  double harmonic_x = 0;
  double harmonic_y = 0;
  double n = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double rho = std::hypot(x - kHalf, y - kHalf);
      if (rho < 17 || rho > 19) continue;
      harmonic_x += parts.turning.at(x, y) * ((x - kHalf) / rho);
      harmonic_y += parts.turning.at(x, y) * ((y - kHalf) / rho);
      ++n;
    }
  // The shift is 1 px/rad: all of it would be 50 erfc' = 94 / sqrt(pi) / 1.2 grey levels at the rim, about 30
  // in the mean over this ring. Less than a hundredth is left.
  EXPECT_LT(2 * std::hypot(harmonic_x, harmonic_y) / n, 0.3);
}

}  // namespace
}  // namespace tribotrack::vision
