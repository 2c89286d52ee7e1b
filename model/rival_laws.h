// Laws of friction beside the paper's, to tell whether data ask for them.
//   const std::vector<RivalLaw> laws{{.viscous = 0.5}};                   // mu g + 0.5 1/s |u|
//   const Eigen::Matrix2Xd moved = rival_positions(scenario, {scenario.end_time()}, laws);   // m
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::model {

/// What friction takes from the relative speed |u|,
///   m(t, |u|) = mu(t, |u|) g (1 + stribeck exp(-(|u|/v_s)^2)) + viscous |u|,
/// v_s = `fading` or, where that is 0, A w/4 (a quarter of the initial speed where the platform rests),
/// where mu2 is mu2 (1 + mu2_speed |u|/(A w)) and each change of mu between mu1 and mu2 is a ramp. A part at
/// rest is held up to (1 + static_friction) m(t, 0). mu1 and mu2 themselves may be higher, so that laws
/// beside each other tell the derivatives by them. All 0: the paper's law. A scenario's own viscous part adds
/// to each law's.
struct RivalLaw {
  double stribeck = 0;         ///< friction at rest is higher by this share; above -1
  double fading = 0;           ///< m/s
  double viscous = 0;          ///< 1/s
  double rise = 0;             ///< s, of each change of mu; its middle lies at the edge; >= 0
  double mu2_speed = 0;        ///< share by which mu2 is higher at the platform's speed
  double static_friction = 0;  ///< share by which friction at rest holds more than it takes from motion
  double mu1 = 0, mu2 = 0;     ///< shares by which they are higher
  bool operator==(const RivalLaw&) const = default;
};

/// That are integrated together: the lanes of a vector register.
constexpr std::size_t kMostRivalLaws = 8;

/// Positions under one to kMostRivalLaws laws, m, a column each: rows 2 k and 2 k + 1 are x and y at
/// `times`[k], s from the start. A Rosenbrock method of order 4 (3), L-stable since a part that creeps is
/// stiff, that stops and starts anew wherever a mu has a kink, with sticking decided by the friction at rest;
/// cubic between steps. All laws take the same steps, so that most of their errors cancel in differences.
/// `tolerance` is of each step, relative to A and A w (the initial speed where the platform rests) and to the
/// way and the speed. A general integrator without derivatives, slower than integrate(). Throws
/// InvalidParameter for a Stribeck strength of -1 and below, which makes friction negative at rest, or a
/// negative fading, for a rise longer than the pulse or the pause, for a start other than rest, where `times`
/// is empty or does not ascend, and where too many steps are needed. Viscous friction of negative strength,
/// which a fit may try, is taken as it stands, unless at the speed A w friction as a whole were negative: it
/// would push the part.
Eigen::MatrixXd rival_positions(const Scenario& scenario, const std::vector<double>& times,
                                std::span<const RivalLaw> laws, double tolerance = 1e-9);

}  // namespace tribotrack::model
