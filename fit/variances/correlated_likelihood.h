// The restricted likelihood of the variances of correlated errors, from sums over each run.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

/// A number for each part.
using PartNumbers = Eigen::Matrix<double, static_cast<int>(kErrorParts), 1>;
using PartSquare = Eigen::Matrix<double, static_cast<int>(kErrorParts), static_cast<int>(kErrorParts)>;

/// All that the likelihood needs of one run: U'U and U'[J r].
struct CorrelatedRunSums {
  Eigen::MatrixXd shapes, data;
  std::vector<std::size_t> part;  ///< of each column of U
};

struct CorrelatedSums {
  std::vector<CorrelatedRunSums> runs;
  Eigen::MatrixXd data;  ///< [J r]'[J r] of all rows
  PartNumbers unit;      ///< m^2: the variance of each part at which it is as large as the white noise
};

/// Of the residuals at `values` and their Jacobian, whitened but for correlated errors; no runs where the
/// model fails.
CorrelatedSums correlated_sums_of(const Residuals& residuals, const Eigen::VectorXd& values);

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
