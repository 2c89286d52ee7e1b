// Covariance from the whitened sensitivity at the minimum.
#pragma once

#include <Eigen/Core>

#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

/// The information on the reported parameters with all others (scale as a nuisance, initial velocities)
/// marginalised, by the singular values of the whitened sensitivity in natural units.
struct Uncertainty {
  Eigen::MatrixXd covariance;       ///< of the reported parameters, SI; flat directions left out
  Eigen::MatrixXd full_covariance;  ///< of all unknowns, likewise
  Eigen::VectorXd singular_values;  ///< falling
  Eigen::MatrixXd directions;       ///< columns: right singular vectors, in natural units
  Eigen::VectorXd units;            ///< natural units of the reported parameters
  Eigen::Index rank = 0;
  Eigen::VectorXd column_norms;  ///< how strongly each parameter alone moves the data
};

/// `jacobian` by physical values. A direction weaker than 1e-9 of the strongest is flat.
Uncertainty uncertainty(const Unknowns& unknowns, const Eigen::VectorXd& values,
                        const Eigen::MatrixXd& jacobian);

}  // namespace tribotrack::fit::internal
