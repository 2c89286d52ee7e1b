// The periodic motion as the fixed point of the one-cycle map, and its derivatives.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <optional>

#include "model/scenario.h"

namespace tribotrack::model::internal {

/// Fixed point U = P(U) in scaled units at the scenario's start phase.
struct Orbit {
  Eigen::Vector2d velocity, drift;
  Eigen::Matrix2d jacobian;  ///< of the one-cycle map
  int iterations = 0;

  double contraction() const {
    const double half = 0.5 * jacobian.trace(), det = jacobian.determinant(), square = half * half - det;
    return square < 0 ? std::sqrt(det) : std::fabs(half) + std::sqrt(square);
  }
};

/// nullopt where there is none that attracts. The Jacobian is good to `jacobian_error` at least. Throws
/// StepLimitExceeded where the whole search takes more than `max_steps` steps.
std::optional<Orbit> find_orbit(const Scenario& scenario, bool with_pulses, double tolerance,
                                double jacobian_error, long max_steps);

}  // namespace tribotrack::model::internal
