// Fewer rows for the same step.
#include "fit/minimum/minimise.h"

#include <gtest/gtest.h>

namespace tribotrack::fit::internal {
namespace {

TEST(Compress, KeepsTheNormalEquationsAndTheSumOfSquares) {
  std::srand(4);
  const Eigen::Index columns = 6;
  for (const Eigen::Index rows : {20, 512, 513, 3000}) {
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Random(rows, columns);
    jacobian.col(4).head(rows / 2).setZero();  // as of a nuisance of later runs
    jacobian.col(5).tail(rows / 2).setZero();
    const Eigen::VectorXd residuals = Eigen::VectorXd::Random(rows);
    const Rows few = compress(jacobian, residuals);
    EXPECT_EQ(few.jacobian.rows(), compressed_rows(rows, columns));
    EXPECT_LE(few.jacobian.rows(), rows <= 512 ? rows : (rows / 512 + 1) * (columns + 1));
    const double scale = static_cast<double>(rows);
    EXPECT_LT((few.jacobian.transpose() * few.jacobian - jacobian.transpose() * jacobian).norm(),
              1e-14 * scale);
    EXPECT_LT((few.jacobian.transpose() * few.residuals - jacobian.transpose() * residuals).norm(),
              1e-14 * scale);
    EXPECT_NEAR(few.residuals.squaredNorm(), residuals.squaredNorm(), 1e-14 * scale);
  }
}

}  // namespace
}  // namespace tribotrack::fit::internal
