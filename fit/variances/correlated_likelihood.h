// The restricted likelihood of slow errors' variances.
#pragma once

#include <Eigen/Core>
#include <array>

#include "fit/variances/correlated_sums.h"

namespace tribotrack::fit::internal {

/// The restricted likelihood at variances (in their units), its slope, Fisher's information, and what the
/// unknowns' covariance does.
struct SlowLikelihood {
  double log = 0;
  SlowNumbers slope = SlowNumbers::Zero();
  SlowSquare information = SlowSquare::Zero();
  Eigen::MatrixXd covariance;
  std::array<Eigen::MatrixXd, kSlowParts> by_variance;  ///< of the covariance
};

/// See slow_variances.h for the formula.
SlowLikelihood slow_likelihood_at(const SlowSums& sums, const SlowNumbers& variances);

}  // namespace tribotrack::fit::internal
