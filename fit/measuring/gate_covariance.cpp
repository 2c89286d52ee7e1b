#include "fit/gate_timing.h"

#include "model/trajectory.h"

namespace tribotrack::fit {

Eigen::Matrix2d displacement_covariance_of_gate(const model::Scenario& scenario,
                                                const Eigen::Matrix2d& gate_covariance) {
  model::IntegrationOptions options;
  options.tolerance = 1e-10;
  options.derivatives = {model::Parameter::phi, model::Parameter::dtau};
  const Eigen::Matrix2d by_gate = model::integrate(scenario, options).sensitive_end().position_jacobian;
  return by_gate * gate_covariance * by_gate.transpose();
}

}  // namespace tribotrack::fit
