// Alternative friction laws, to test whether data reject the paper's.
//   const RivalLaw law{RivalLaw::Kind::viscous, 0.5};                     // mu g + 0.5 1/s |u|
//   const Eigen::Vector2d moved = rival_displacement(scenario, law);      // m
#pragma once

#include <Eigen/Core>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::model {

/// The paper's law with one more number, `strength`, that is 0 for the paper's law itself.
struct RivalLaw {
  enum class Kind {
    coulomb,   ///< mu g, whatever the speed (the paper); strength unused
    stribeck,  ///< mu g (1 + strength exp(-(|u|/v_s)^2)), v_s = A w/4 (a quarter of the initial speed where
               ///< the platform rests): friction falls (strength > 0) with speed
    viscous,   ///< mu g + strength |u|; strength in 1/s
    rise_time  ///< the actuator takes `strength` seconds for each change of mu: a trapezoid that begins at
               ///< the edges
  };
  Kind kind = Kind::coulomb;
  double strength = 0;
};

const char* to_string(RivalLaw::Kind kind);

/// Displacement at the end of the run, m: Dormand-Prince 5(4) that stops and starts anew wherever mu has a
/// kink, with sticking decided by the friction at rest. `tolerance` is relative to A and A w (the initial
/// speed where the platform rests). A general integrator without derivatives, some ten times slower than
/// integrate(). Throws InvalidParameter for a Stribeck strength of -1 and below, which makes friction
/// negative at rest, for a rise longer than the pulse or the pause, for a start other than rest, and where
/// too many steps are needed. Viscous friction of negative strength, which a fit may try, is taken as it
/// stands.
Eigen::Vector2d rival_displacement(const Scenario& scenario, const RivalLaw& law, double tolerance = 1e-9);

/// Positions at increasing times from the start, none beyond the end, m: columns.
Eigen::Matrix2Xd rival_positions(const Scenario& scenario, const RivalLaw& law,
                                 const std::vector<double>& times, double tolerance = 1e-9);

}  // namespace tribotrack::model
