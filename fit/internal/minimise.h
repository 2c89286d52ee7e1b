// One descent with Ceres.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fit/internal/residuals.h"

namespace tribotrack::fit::internal {

struct Minimum {
  Eigen::VectorXd z;
  double chi2 = 0;
  bool converged = false;
  bool joined = false;  ///< stopped because it entered the basin of a known minimum
};

/// A minimum with its curvature, so that other starts can tell that they fall into it.
struct KnownMinimum {
  Minimum minimum;
  Eigen::MatrixXd curvature;  ///< J'J by z
};

struct MinimiseOptions {
  std::optional<Eigen::Index> held;  ///< this z stays as it is (profiles)
  double function_tolerance = 1e-12;
  int max_iterations = 100;
  const std::vector<KnownMinimum>* known = nullptr;
};

/// Levenberg-Marquardt on DENSE_QR (rank-deficient steps are damped), one thread, no bounds: the z axes have
/// none. Derivatives are the model's.
Minimum minimise(const Residuals& residuals, const Eigen::VectorXd& start,
                 const MinimiseOptions& options = {});

KnownMinimum with_curvature(const Residuals& residuals, const Minimum& minimum);

}  // namespace tribotrack::fit::internal
