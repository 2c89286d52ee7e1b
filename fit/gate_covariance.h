// What not knowing the gate exactly does to the displacement a run is compared with.
#pragma once

#include <Eigen/Core>

#include "model/scenario.h"

namespace tribotrack::fit {

/// J C J^T, m^2: J = d(displacement)/d(phi, dtau) of the scenario as it stands (its mu1, mu2, lag: guesses
/// do), C the covariance of the measured phi and dtau, rad^2.
Eigen::Matrix2d displacement_covariance_of_gate(const model::Scenario& scenario,
                                                const Eigen::Matrix2d& gate_covariance);

}  // namespace tribotrack::fit
