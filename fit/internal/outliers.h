// Which run does not belong to the others.
#pragma once

#include "fit/estimate.h"
#include "fit/internal/minimise.h"

namespace tribotrack::fit::internal {

/// Every summary run judged by the fit to all others, to first order: chi^2 falls by
///   D = r'(1 - H)^-1 r,  H = J_i (J'J)^-1 J_i'  (deleted residual of two components)
/// when it is left out, to be compared with what is left, F = (D/2)/(chi^2 - D)*(dof - 2) (externally
/// studentised; where the rest agrees with its sigma, with the sigma instead). A run is named when so large a
/// D has a chance below 1 % among all of them. Where turning its pulse by an angle would bring it back
/// (rotation law), the phi it looks like is told, too.
std::vector<Outlier> find_outliers(const Residuals& residuals, const Minimum& best,
                                   const Eigen::MatrixXd& full_covariance);

}  // namespace tribotrack::fit::internal
