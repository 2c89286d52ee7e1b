// Refits under another friction law.
#pragma once

#include "fit/minimum/minimise.h"
#include "model/rival_laws.h"

namespace tribotrack::fit::internal {

struct RivalFit {
  bool converged = false;
  double chi2 = 0;
  Eigen::VectorXd z;            ///< of the unknowns; under a rise time the lag is that of the ramp's middle
  double strength = 0, sd = 0;  ///< of the law, SI
};

/// Runs and priors, fitted under `law` from the minimum of the paper's: Levenberg-Marquardt on
/// central differences (steps a thousandth of each natural unit, integrated to 1e-9: errors near 1e-6), the
/// strength one unknown more unless the law has none.
RivalFit fit_rival(const Residuals& residuals, const Minimum& best, model::RivalLaw::Kind law, int threads);

/// The size a strength is judged by: 1 for Stribeck, w/10 for a viscous part, 0.1/w for a rise time.
double strength_unit(model::RivalLaw::Kind law, double angular_frequency);

}  // namespace tribotrack::fit::internal
