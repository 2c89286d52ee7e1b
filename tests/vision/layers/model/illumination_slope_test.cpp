#include "vision/layers/model/light.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <random>
#include <vector>

namespace tribotrack::vision {
namespace {

/// Along a path that winds, the slopes of a parabola of light.
std::vector<MeasuredSlope> slopes_of_parabola(int n, double noise, std::mt19937& random) {
  std::normal_distribution<double> error(0, 1);
  std::vector<MeasuredSlope> slopes;
  for (int k = 0; k < n; ++k) {
    const Point p{100 + 1.3 * k, 60 + 20 * std::sin(0.3 * k)};
    slopes.push_back({p, 3e-4 - 2e-6 * (p.x - 320) + 5e-7 * p.y + noise * error(random),
                      -2e-6 * (p.y - 200) + 5e-7 * p.x + noise * error(random), noise * noise});
  }
  return slopes;
}

TEST(IlluminationSlope, KnowsNothingAtFirst) {
  EXPECT_EQ(IlluminationSlope().at({1, 2}).sd, 0);
}

// The field is exact at the places' mean; away from it it is drawn to an even slope as if half a pixel of
// spread told of none, so by no more than 1/4 px^2 over the places' least mean square.
TEST(IlluminationSlope, ParabolaIsFoundUpToHalfAPixelOfSpread) {
  std::mt19937 random(1);
  const std::vector<MeasuredSlope> slopes = slopes_of_parabola(40, 0, random);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
  for (const MeasuredSlope& s : slopes) mean += Eigen::Vector2d(s.place.x, s.place.y) / 40;
  for (const MeasuredSlope& s : slopes) {
    const Eigen::Vector2d off = Eigen::Vector2d(s.place.x, s.place.y) - mean;
    square += off * off.transpose() / 40;
  }
  const IlluminationSlope field(slopes);
  ASSERT_TRUE(field.known());
  const Eigen::Matrix2d curvature{{-2e-6, 5e-7}, {5e-7, -2e-6}};
  const Eigen::Vector2d middle{3e-4 - 2e-6 * (mean.x() - 320) + 5e-7 * mean.y(),
                               -2e-6 * (mean.y() - 200) + 5e-7 * mean.x()};
  const LightPrior there = field.at({mean.x(), mean.y()});
  EXPECT_NEAR(there.slope_x, middle.x(), 1e-12);
  EXPECT_NEAR(there.slope_y, middle.y(), 1e-12);
  const Eigen::Vector2d off(70, 90);
  const LightPrior g = field.at({mean.x() + off.x(), mean.y() + off.y()});
  const Eigen::Vector2d exact = middle + curvature * off;
  const Eigen::Vector2d drawn =
      middle + curvature * (square + 0.25 * Eigen::Matrix2d::Identity()).inverse() * square * off;
  EXPECT_NEAR(g.slope_x, drawn.x(), 1e-10);
  EXPECT_NEAR(g.slope_y, drawn.y(), 1e-10);
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(square).eigenvalues()(0);
  EXPECT_LT((drawn - exact).norm(), 0.25 / least * (curvature * off).norm());
}

// Chance passes once in 4000 fields.
TEST(IlluminationSlope, SlopesThatAreNoiseOnlyAreNotKnown) {
  for (unsigned seed = 0; seed < 500; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> error(0, 1e-4);
    std::vector<MeasuredSlope> slopes = slopes_of_parabola(40, 0, random);
    for (MeasuredSlope& s : slopes) s = {s.place, error(random), error(random), 1e-8};
    const IlluminationSlope field(slopes);
    ASSERT_FALSE(field.known()) << seed;
    ASSERT_EQ(field.at({130, 60}).sd, 0);
  }
}

// Nor are slopes that scatter by more than is said of them, whose mean and trend are chance: what pictures
// not yet right leave.
TEST(IlluminationSlope, ScatterWithoutAFieldIsNotKnown) {
  for (unsigned seed = 0; seed < 500; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> error(0, 3e-4);
    std::vector<MeasuredSlope> slopes = slopes_of_parabola(40, 0, random);
    for (MeasuredSlope& s : slopes) s = {s.place, error(random), error(random), 1e-8};
    ASSERT_FALSE(IlluminationSlope(slopes).known()) << seed;
  }
}

TEST(IlluminationSlope, ClearFieldIsKnown) {
  for (unsigned seed = 0; seed < 500; ++seed) {
    std::mt19937 random(seed);
    // 40 slopes of 7e-4 in noise of 3e-4: a ratio of some 25.
    ASSERT_TRUE(IlluminationSlope(slopes_of_parabola(40, 3e-4, random)).known()) << seed;
  }
}

// What it says of a place is right to what it says, within the path and beyond it.
TEST(IlluminationSlope, StandardDeviationHoldsTheErrorOfTheField) {
  const double noise = 2e-5;
  for (const Point& p : {Point{130, 60}, Point{220, 60}}) {
    double square = 0, told = 0;
    constexpr int kTrials = 2000;
    for (int i = 0; i < kTrials; ++i) {
      std::mt19937 random(static_cast<unsigned>(100 + i));
      const IlluminationSlope field(slopes_of_parabola(40, noise, random));
      const LightPrior g = field.at(p);
      square += std::pow(g.slope_x - (3e-4 - 2e-6 * (p.x - 320) + 5e-7 * p.y), 2);
      told += g.sd * g.sd;
    }
    // Beside the field's own error it tells a scatter of the frames' light that is at least a tenth of the
    // noise, and by chance up to a fifth more.
    EXPECT_GT(told, square + kTrials * 0.1 * noise * noise);
    EXPECT_LT(told, 1.1 * square + kTrials * 0.3 * noise * noise);
  }
}

TEST(IlluminationSlope, LightOfItsOwnInEveryFrameIsLeftOpen) {
  std::mt19937 random(5);
  std::vector<MeasuredSlope> slopes = slopes_of_parabola(4000, 1e-4, random);
  for (MeasuredSlope& s : slopes) s.variance = 0.25e-8;  // a quarter of what they scatter by
  EXPECT_NEAR(IlluminationSlope(slopes).at({2700, 60}).sd, std::sqrt(0.75e-8 + 0.1 * 0.25e-8), 2e-6);
}

TEST(IlluminationSlope, PartThatNeverMovesHasOneSlope) {
  std::vector<MeasuredSlope> slopes(20, MeasuredSlope{{50, 60}, 1e-4, 2e-4, 1e-10});
  const LightPrior g = IlluminationSlope(slopes).at({50, 60});
  EXPECT_NEAR(g.slope_x, 1e-4, 1e-12);
  EXPECT_NEAR(g.slope_y, 2e-4, 1e-12);
  EXPECT_GT(g.sd, 0);
  EXPECT_LT(g.sd, 1e-5);
}

}  // namespace
}  // namespace tribotrack::vision
