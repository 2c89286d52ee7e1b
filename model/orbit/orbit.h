// The periodic motion as the fixed point of the one-cycle map, and its derivatives.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "model/equation/matrix2.h"
#include "model/scenario.h"

namespace tribotrack::model::internal {

/// Fixed point U = P(U) in scaled units at the scenario's start phase.
struct Orbit {
  Eigen::Vector2d velocity, drift;
  Eigen::Matrix2d jacobian;  ///< of the one-cycle map
  int iterations = 0;

  double contraction() const {
    return spectral_radius({jacobian(0, 0), jacobian(0, 1), jacobian(1, 0), jacobian(1, 1)});
  }
};

/// nullopt where there is none that attracts. The Jacobian is good to `jacobian_error` at least. Throws
/// StepLimitExceeded where the whole search takes more than `max_steps` steps.
std::optional<Orbit> find_orbit(const Scenario& scenario, bool with_pulses, double tolerance,
                                double jacobian_error, long max_steps);

}  // namespace tribotrack::model::internal
