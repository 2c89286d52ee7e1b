// The periodic motion the part settles into, found directly.
//
// Under eq. (5) two motions never separate: |u - u'| does not grow, and shrinks while both slip under
// friction. So where friction acts at all and can hold the mean of the drive there is one periodic motion,
// which every run approaches; it is the root of P(U) - U, P being the map of the velocity over one cycle.
//   if (const auto orbit = steady_orbit(scenario))
//     use(orbit->alpha(), orbit->mean_velocity(scenario.drive.angular_frequency));
#pragma once

#include <Eigen/Core>
#include <optional>

#include "model/alpha_v.h"
#include "model/scenario.h"

namespace tribotrack::model {

/// One period of the unique attracting motion.
struct SteadyOrbit {
  Eigen::Vector2d velocity;  ///< u at the platform phase scenario.start_phase, m/s
  Eigen::Vector2d drift;     ///< displacement per cycle, m
  double contraction =
      0;  ///< spectral radius of the one-cycle velocity map at the orbit, to 1e-4; 0 with stick
  int newton_iterations = 0;
  double alpha() const { return displacement_angle(drift); }  ///< direction of the drift, rad in [0, 2 pi)
  double mean_velocity(double angular_frequency) const;       ///< v = |drift| w / 2 pi, m/s
};

/// Newton's method on the one-cycle map; a cycle where stick wipes the memory. From the platform phase
/// scenario.start_phase. `with_pulses = false`: the motion at constant mu1 ("circling"). nullopt where no
/// unique steady motion exists (no friction anywhere in the cycle, tilt beyond the friction angle). Throws
/// InvalidParameter for a bad scenario, and StepLimitExceeded where the search takes more steps than
/// IntegrationOptions::max_steps is by default.
std::optional<SteadyOrbit> steady_orbit(const Scenario& scenario, bool with_pulses = true);

}  // namespace tribotrack::model
