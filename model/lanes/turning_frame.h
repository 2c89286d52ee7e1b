// A run as seen from the frame that turns with a circular drive.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "model/equation/edges.h"
#include "model/scenario.h"
#include "model/solver/set_up.h"

namespace tribotrack::model::internal {

/// Units: the drive's length a, its phase. The fixed frame here is the one with the drive along x at the
/// local phase 0, turning from x to y (reflected where the real one turns the other way).
struct TurningFrame {
  double kappa_nominal = 0, kappa_reduced = 0;
  Edges<double> edges;
  bool circling = false;  ///< a pulse already open at the start does not count
  double cycles = 0, rest = 0;
  Pair<double> velocity;  ///< at the start

  double kappa(bool reduced) const { return reduced ? kappa_reduced : kappa_nominal; }
  Eigen::Vector2d in_metres(const Pair<double>& x) const {
    return length * Eigen::Vector2d(cosine * x.x - sense * sine * x.y, sine * x.x + sense * cosine * x.y);
  }

  double length = 1;  ///< m
  double cosine = 1, sine = 0, sense = 1;
};

/// Nothing where the drive is no circle (elliptic, tilted, A = 0).
std::optional<TurningFrame> turning_frame(const Scenario& scenario);

}  // namespace tribotrack::model::internal
