// The vector arithmetic gives what the formulas of the headers give, summed slowly in double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "vision/kernels/bspline.h"
#include "vision/kernels/tile_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kTiles = 5, kCount = kTiles * kTilePixels;
constexpr double kFloatSums = 2e-5;  // of sums of a few hundred floats, relative to the sum of their sizes

std::vector<float> draw(std::mt19937& random, double mean, double spread, std::size_t count = kCount) {
  std::uniform_real_distribution<double> uniform(mean - spread, mean + spread);
  std::vector<float> out(count);
  for (float& x : out) x = static_cast<float>(uniform(random));
  return out;
}

/// A sum and the sum of its terms' sizes.
struct SlowSum {
  double value = 0, size = 0;
  void add(double term) {
    value += term;
    size += std::abs(term);
  }
  void expect(double fast, const char* what, std::size_t i = 0) const {
    EXPECT_NEAR(fast, value, kFloatSums * size) << what << ' ' << i;
    EXPECT_GT(size, 0) << what;
  }
};

TileArrays tiles(std::mt19937& random) {
  TileArrays a;
  a.tiles = kTiles;
  a.value = draw(random, 10, 40);
  a.slope_x = draw(random, 0, 9);
  a.slope_y = draw(random, 0, 9);
  a.slope_theta = draw(random, 0, 30);
  a.level = draw(random, 100, 60);
  a.weight = draw(random, 0.5, 0.5);
  for (std::size_t i = 0; i < kCount; i += 7) a.weight[i] = 0;
  return a;
}

TEST(VectorKernels, SumsOverTiles) {
  std::mt19937 random(5);
  const TileArrays a = tiles(random);
  constexpr float gain = 1.125F, offset = 90;
  std::array<SlowSum, 5> force;
  std::array<SlowSum, 15> normal;
  std::array<std::array<SlowSum, 5>, kTiles> scores;
  SlowSum squares, weight, vl, ll;
  double largest = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    const double w = a.weight[i], r = double{a.level[i]} - double{gain} * a.value[i] - offset;
    const std::array<double, 5> jacobian = {-a.slope_x[i], -a.slope_y[i], a.value[i], 1, a.slope_theta[i]};
    for (std::size_t j = 0, at = 0; j < 5; ++j) {
      force[j].add(w * jacobian[j] * r);
      scores[i / kTilePixels][j].add(w * jacobian[j] * r);
      for (std::size_t k = j; k < 5; ++k, ++at) normal[at].add(w * jacobian[j] * jacobian[k]);
    }
    squares.add(w * r * r);
    weight.add(w);
    vl.add(w * a.value[i] * a.level[i]);
    ll.add(w * a.level[i] * a.level[i]);
    if (w > 0) largest = std::max(largest, std::abs(r));
  }
  const ForceSums f = force_sums(a, gain, offset);
  for (std::size_t j = 0; j < 5; ++j) force[j].expect(f.force[j], "force", j);
  squares.expect(f.squares, "squares");
  weight.expect(f.weight, "weight");
  EXPECT_NEAR(f.largest, largest, 1e-4);
  const NormalSums n = normal_sums(a);
  for (std::size_t j = 0; j < 15; ++j) normal[j].expect(n[j], "normal", j);
  const CorrelationSums c = correlation_sums(a, a.weight);
  vl.expect(c.vl, "vl");
  ll.expect(c.ll, "ll");
  for (std::size_t t = 0; t < kTiles; ++t) {
    const ForceSums of_tile = force_sums(a, gain, offset, t, t + 1);
    for (std::size_t j = 0; j < 5; ++j) scores[t][j].expect(of_tile.force[j], "score", 5 * t + j);
  }
}

TEST(VectorKernels, SplineAtAnyPlaceIsTheSplineItself) {
  std::mt19937 random(8);
  constexpr int kWidth = 23, kHeight = 19;
  Picture picture(kWidth, kHeight);
  const auto levels = draw(random, 100, 50, kWidth * kHeight);
  std::copy(levels.begin(), levels.end(), picture.levels().begin());
  const QuinticSpline spline(picture);
  std::vector<float> x = draw(random, 0.5 * kWidth, 0.5 * kWidth + 8, 500), y(x);
  y = draw(random, 0.5 * kHeight, 0.5 * kHeight + 8, 500);
  x[0] = y[0] = 7;  // whole
  x[1] = -0.25F;
  std::vector<float> value(x.size()), slope_x(x), slope_y(x), alone(x);
  spline.sample_places(x, y, value.data(), slope_x.data(), slope_y.data());
  spline.sample_places(x, y, alone.data(), nullptr, nullptr);
  for (std::size_t k = 0; k < x.size(); ++k) {
    const bool clamped = x[k] < -5 || y[k] < -5 || x[k] > kWidth + 3.9F || y[k] > kHeight + 3.9F;
    const SplineSample slow = spline.sample(x[k], y[k]);
    // Beyond the border the spline still has its slope where the place is held at 4 - 0.01 or 0.001 px.
    EXPECT_NEAR(value[k], slow.value, clamped ? 1.0 : 2e-3) << x[k] << ' ' << y[k];
    EXPECT_EQ(alone[k], value[k]);
    if (clamped) continue;
    EXPECT_NEAR(slope_x[k], slow.slope_x, 2e-3) << x[k] << ' ' << y[k];
    EXPECT_NEAR(slope_y[k], slow.slope_y, 2e-3) << x[k] << ' ' << y[k];
  }
}

}  // namespace
}  // namespace tribotrack::vision
