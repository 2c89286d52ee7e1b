// The restricted likelihood of the variances of correlated errors.
#pragma once

#include <Eigen/Core>
#include <array>

#include "fit/variances/correlated_sums.h"

namespace tribotrack::fit::internal {

/// The restricted likelihood at variances (in their units), its slope, Fisher's information, and what the
/// unknowns' covariance does.
struct CorrelatedLikelihood {
  double log = 0;
  PartNumbers slope = PartNumbers::Zero();
  PartSquare information = PartSquare::Zero();
  Eigen::MatrixXd covariance;
  std::array<Eigen::MatrixXd, kErrorParts> by_variance;  ///< of the covariance
};

/// See correlated_variances.h for the formula.
CorrelatedLikelihood correlated_likelihood_at(const CorrelatedSums& sums, const PartNumbers& variances);

}  // namespace tribotrack::fit::internal
