#include "fit/pooling.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "fit/tools/statistics.h"

namespace tribotrack::fit {
namespace {

constexpr double pi = std::numbers::pi;

TEST(Pooling, ThreeValuesByHand) {
  // Weights 1, 1/4, 1: mean (1 + 0.5 + 4) / 2.25, chi2 = sum w d^2.
  const std::vector<Estimate> values = {{1, 1}, {2, 2}, {4, 1}};
  const Pooled pooled = pool(values);
  const double mean = 5.5 / 2.25;
  EXPECT_DOUBLE_EQ(pooled.mean.value, mean);
  EXPECT_DOUBLE_EQ(pooled.mean.sd, 1 / 1.5);
  EXPECT_DOUBLE_EQ(pooled.chi2, std::pow(1 - mean, 2) + std::pow(2 - mean, 2) / 4 + std::pow(4 - mean, 2));
  EXPECT_NEAR(pooled.p_value, std::exp(-pooled.chi2 / 2), 1e-14);  // two degrees of freedom
  EXPECT_EQ(pooled.count, 3u);
  EXPECT_TRUE(pooled.one_value());
}

TEST(Pooling, RefusesAtOneInAThousandOnBothSidesOfTheEdge) {
  // Two values d apart with sd 1: chi2 = d^2 / 2 with one degree of freedom.
  const double edge = std::sqrt(2 * internal::chi2_quantile(1 - kRefusedByChance, 1));
  EXPECT_TRUE(pool(std::vector<Estimate>{{0, 1}, {0.999 * edge, 1}}).one_value());
  const Pooled refused = pool(std::vector<Estimate>{{0, 1}, {1.001 * edge, 1}});
  EXPECT_FALSE(refused.one_value());
  EXPECT_NEAR(refused.mean.sd, 0.5 * 1.001 * edge, 1e-12);  // the scatter's, not 1 / sqrt(2)
}

TEST(Pooling, AnglesCountNoTurn) {
  const std::vector<Estimate> values = {{pi - 0.01, 0.1}, {-pi + 0.03, 0.1}, {5 * pi + 0.01, 0.1}};
  const Pooled pooled = pool_angles(values);
  EXPECT_NEAR(pooled.mean.value, pi + 0.01, 1e-12);
  EXPECT_LT(pooled.chi2, 1);
}

TEST(Pooling, ExactValuesAreEqualOrRefused) {
  EXPECT_TRUE(pool(std::vector<Estimate>{{2, 0}, {2, 0}}).one_value());
  EXPECT_EQ(pool(std::vector<Estimate>{{2, 0}, {2, 0}}).mean.sd, 0);
  EXPECT_FALSE(pool(std::vector<Estimate>{{2, 0}, {2.1, 0}}).one_value());
  EXPECT_THROW(pool({}), std::invalid_argument);
  EXPECT_THROW(pool(std::vector<Estimate>{{2, -1}}), std::invalid_argument);
}

TEST(Pooling, TwoOpinionsAndExactOnes) {
  const Estimate mean = combined({1, 3}, {6, 4});
  EXPECT_DOUBLE_EQ(mean.value, (1.0 / 9 + 6.0 / 16) / (1.0 / 9 + 1.0 / 16));
  EXPECT_DOUBLE_EQ(mean.sd, 2.4);
  EXPECT_EQ(combined({1, 0}, {6, 4}).value, 1);
  EXPECT_EQ(combined({1, 3}, {6, 0}).value, 6);
  EXPECT_EQ(combined({1, 0}, {6, 0}).value, 1);
}

TEST(Pooling, OneOfTwoKnownTogetherMovesTheOther) {
  const Eigen::Vector2d both(1, 2);
  const Eigen::Matrix2d together = (Eigen::Matrix2d() << 4, -3, -3, 9).finished();
  Eigen::VectorXd values = both, exact = both;
  Eigen::MatrixXd covariance = together, known = together;
  take_in(exact, known, 1, {5, 0});  // conditional on the second
  EXPECT_DOUBLE_EQ(exact(0), 1 - 3.0 / 9 * 3);
  EXPECT_DOUBLE_EQ(exact(1), 5);
  EXPECT_DOUBLE_EQ(known(0, 0), 4 - 9.0 / 9);
  EXPECT_NEAR(known(1, 1), 0, 1e-15);

  take_in(values, covariance, 1, {5, 2});
  Eigen::Matrix2d more = together.inverse();
  more(1, 1) += 0.25;
  EXPECT_TRUE(covariance.isApprox(more.inverse(), 1e-12));
}

}  // namespace
}  // namespace tribotrack::fit
