// Arrows of rows against dense matrices of all unknowns.
#include "fit/residuals/linearised.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace tribotrack::fit::internal {
namespace {

constexpr Eigen::Index kShared = 4, kUnknowns = 4 + 2 + 3;

RowGroup group(Eigen::Index rows, Eigen::Index own, Eigen::Index first_own) {
  return {Eigen::VectorXd::Random(rows), Eigen::MatrixXd::Random(rows, kShared),
          Eigen::MatrixXd::Random(rows, own), first_own};
}

struct LinearisedRows : testing::Test {
  LinearisedRows() {
    std::srand(4);
    at.groups = {group(7, 0, kShared), group(700, 2, kShared), group(900, 3, kShared + 2)};
    jacobian = at.jacobian(kUnknowns);
    r = at.residuals();
    covariance = (jacobian.transpose() * jacobian).inverse();
  }
  Linearised at;
  Eigen::MatrixXd jacobian, covariance;
  Eigen::VectorXd r;
};

TEST_F(LinearisedRows, EliminatedHaveTheCovarianceOfTheSharedUnknowns) {
  const Eigen::MatrixXd found = shared_covariance(at, 1e-13);
  EXPECT_LT((found - covariance.topLeftCorner(kShared, kShared)).norm(), 1e-12 * found.norm());
  const Eigen::MatrixXd triangle = at.eliminated().triangle();
  EXPECT_LT((triangle.transpose() * triangle - found.inverse()).norm(), 1e-12 * found.inverse().norm());
}

TEST_F(LinearisedRows, DecrementIsThatOfAllUnknowns) {
  const Eigen::VectorXd gradient = jacobian.transpose() * r;
  EXPECT_NEAR(newton_decrement(at), gradient.dot(covariance * gradient), 1e-10);
  const Eigen::MatrixXd others = jacobian.rightCols(kUnknowns - 1);
  const Eigen::VectorXd slope = others.transpose() * r;
  EXPECT_NEAR(newton_decrement(at, 0), slope.dot((others.transpose() * others).ldlt().solve(slope)), 1e-10);
}

TEST_F(LinearisedRows, OwnUnknownsFollowTheSharedOnesByLeastSquares) {
  const Eigen::VectorXd step = at.following(covariance.col(0).head(kShared), kUnknowns);
  EXPECT_LT((step - covariance.col(0)).norm(), 1e-12 * step.norm());
  EXPECT_NEAR(at.squared(step), (jacobian * step).squaredNorm(), 1e-12);
}

}  // namespace
}  // namespace tribotrack::fit::internal
