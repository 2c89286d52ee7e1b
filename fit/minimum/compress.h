// Least squares with fewer rows.
#pragma once

#include <Eigen/Core>

namespace tribotrack::fit::internal {

struct Rows {
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd residuals;
};

/// Rows with the same J'J, J'r and r'r, which is all that a Gauss-Newton step needs: blocks of
/// rows are replaced by the triangle of their QR decomposition (Golub and Van Loan, Matrix Computations,
/// 5.3), columns that are zero in a block left out of it.
/// Rows that are not needed stay zero.
Rows compress(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals);

/// How many rows are left of so many: it depends on nothing else.
Eigen::Index compressed_rows(Eigen::Index rows, Eigen::Index columns);

}  // namespace tribotrack::fit::internal
