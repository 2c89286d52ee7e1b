// One descent with Ceres, on rows that are compressed where they are many.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

struct Minimum {
  Eigen::VectorXd z;
  double chi2 = 0;
  bool converged = false;
  bool joined = false;        ///< stopped because it entered the basin of a known minimum
  bool abandoned = false;     ///< stopped because it crawls far above a known minimum
  Eigen::VectorXd residuals;  ///< at z, as the descent saw them last
  Eigen::MatrixXd jacobian;   ///< by physical values, likewise
};

/// A minimum with its curvature, by which other descents recognise it.
struct KnownMinimum {
  Minimum minimum;
  Eigen::MatrixXd curvature;  ///< J'J by z
};

struct MinimiseOptions {
  std::optional<Eigen::Index> held;  ///< this z stays as it is (profiles)
  /// Newton's decrement at which to stop: by how much chi^2 would still fall if the model were linear. 1e-10
  /// is 1e-5 standard deviations from the minimum.
  double decrement = 1e-10;
  int max_iterations = 100;
  const std::vector<KnownMinimum>* known = nullptr;
  /// The evaluation at the start, where it was made before (same tolerance, scatter and weights).
  const Minimum* evaluated = nullptr;
};

/// Levenberg-Marquardt on DENSE_QR (rank-deficient steps are damped), one thread, no bounds: the z axes have
/// none. Derivatives are the model's; every point is evaluated once, derivatives and all.
Minimum minimise(const Residuals& residuals, const Eigen::VectorXd& start,
                 const MinimiseOptions& options = {});

KnownMinimum with_curvature(const Residuals& residuals, const Minimum& minimum);

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
