// How others solve the friction model: for comparison only (`tribotrack bench model`). Do not compute results
// with these.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::bench {

struct PeerResult {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m, at the end of the run
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();
  long steps = 0;         ///< tried, rejected ones included
  bool finished = false;  ///< false: max_steps were not enough
};

struct DormandPrinceOptions {
  double relative_tolerance = 1e-6;
  double position_tolerance = 1e-6;  ///< absolute, m
  double velocity_tolerance = 1e-6;  ///< absolute, m/s
  double max_step = 0;               ///< s; 0: none
  /// Stops at every friction switch and starts anew, sees stops (friction exceeds the drive and the velocity
  /// has turned round or is below stop_speed) and releases. Without it mu is taken at each step's time and
  /// the part never sticks: it chatters.
  bool segmented = false;
  double stop_speed = 1e-6;  ///< m/s; what is left of the path, stop_speed^2 / (2 deceleration), is dropped
  long max_steps = 5'000'000;
};

/// The paper's recipe (section 2.2): MATLAB's ode45 with tolerances 1e-6 and a maximum step of 1e-4 s, which
/// knows nothing of the friction switches.
DormandPrinceOptions paper_recipe();

/// Dormand-Prince with every tolerance `tolerance` relative to the scene's own scales A and A w.
DormandPrinceOptions segmented_dormand_prince(const model::Scenario& scenario, double tolerance);

/// Dormand-Prince 5(4) from the scenario's initial velocity. Throws std::invalid_argument unless
/// start = rest.
PeerResult dormand_prince(const model::Scenario& scenario, const DormandPrinceOptions& options);

/// The same method in extended precision (64-bit mantissa), segmented, at 1e-17 of the scene's scales unless
/// given otherwise: an end point independent of the library's integrator, good to about 1e-16 of the path.
/// Slow (about a second).
PeerResult extended_precision_reference(const model::Scenario& scenario, double tolerance = 1e-17);

/// Time stepping of non-smooth mechanics (Moreau-Jean with theta = 1: implicit Euler with the friction disc
/// as a projection): sticks properly, never fails, first order.
PeerResult moreau_jean(const model::Scenario& scenario, double step);

/// A method of others that takes any tolerance, relative to the scene's own scales A and A w.
struct BenchPeer {
  std::string name;
  /// Gives up after max_steps (finished = false).
  std::function<PeerResult(const model::Scenario& scenario, double tolerance, long max_steps)> run;
};

/// Dormand-Prince 5(4), Runge-Kutta-Fehlberg 7(8) and Bulirsch-Stoer of Boost.odeint, begun anew in every
/// segment of constant friction.
std::vector<BenchPeer> odeint_peers();

/// SUNDIALS' CVODE, Adams and BDF, re-initialised at every switch.
std::vector<BenchPeer> cvode_peers();

/// Of this build, which may lack libraries that the product does not need.
std::vector<BenchPeer> library_peers();

/// The libraries this build was made without, such as "SUNDIALS"; empty where it has both.
std::vector<std::string> missing_libraries();

}  // namespace tribotrack::bench
