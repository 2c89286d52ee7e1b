// The residuals about a minimum to second order: refits nearby cost no simulation.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fit/minimum/minimise.h"

namespace tribotrack::fit::internal {

/// r(t) = r_0 + J t + 1/2 sum_jk t_j t_k d2r/dt_j dt_k, in principal axes: z = z_0 + axes t, J'J = 1, so that
/// one unit of any t is a standard deviation. The second derivatives are central differences of exact
/// Jacobians one unit to either side.
class CurvedResiduals {
 public:
  /// About `best` of `residuals`; nullopt where a direction is flat or the model cannot be evaluated a
  /// standard deviation away.
  static std::optional<CurvedResiduals> about(const Residuals& residuals, const Minimum& best, int threads);

  Eigen::VectorXd z(const Eigen::VectorXd& t) const { return z_ + axes_ * t; }
  Eigen::VectorXd at(const Eigen::VectorXd& r0, const Eigen::VectorXd& t) const;
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& t) const;
  /// Where the squares of r(t) are least; nullopt where Gauss and Newton's method does not get there.
  std::optional<Eigen::VectorXd> minimum(const Eigen::VectorXd& r0) const;
  /// The minimum `t` after the step given by the exact residuals there; nullopt where they differ from
  /// the second order by so much, or the step is so long, that its derivatives are not to be trusted. What is
  /// confirmed lies some hundredths of a standard deviation from the true minimum at most.
  std::optional<Eigen::VectorXd> confirmed(const Eigen::VectorXd& r0, const Eigen::VectorXd& t,
                                           const Eigen::VectorXd& exact) const;

 private:
  /// Gauss and Newton's step from t, where the residuals are r.
  Eigen::VectorXd step(const Eigen::VectorXd& r, const Eigen::VectorXd& t) const;

  Eigen::VectorXd z_;
  Eigen::MatrixXd axes_, jacobian_;
  std::vector<Eigen::MatrixXd> second_;  ///< [j]: d jacobian / dt_j
};

}  // namespace tribotrack::fit::internal
