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

// All integrate from the scenario's initial velocity; std::invalid_argument unless start = rest.

/// The paper's recipe (section 2.2): MATLAB's ode45, Dormand-Prince 5(4), with tolerances 1e-6 (m, m/s) and a
/// maximum step of 1e-4 s, which knows nothing of the friction switches: mu is taken at each step's time, and
/// the part never sticks but chatters.
PeerResult paper_recipe(const model::Scenario& scenario, double tolerance = 1e-6, double max_step = 1e-4,
                        long max_steps = 5'000'000);

/// Boost.odeint's Dormand-Prince 5(4), `tolerance` relative to the scene's own scales A and A w. Stops at
/// every friction switch and starts anew, sees stops and releases (equation.h).
PeerResult dormand_prince(const model::Scenario& scenario, double tolerance, long max_steps = 5'000'000);

/// Runge-Kutta-Fehlberg 7(8) in extended precision (64-bit mantissa), likewise: an end point independent of
/// the library's integrator, good to about 1e-16 of the path.
PeerResult extended_precision_reference(const model::Scenario& scenario, double tolerance = 1e-18);

/// Time stepping of non-smooth mechanics (Moreau-Jean with theta = 1: implicit Euler with the friction disc
/// as a projection): sticks properly, never fails, first order.
PeerResult moreau_jean(const model::Scenario& scenario, double step);

/// A method of others that takes any tolerance, relative to the scene's own scales A and A w.
struct BenchPeer {
  std::string name;
  /// Gives up after max_steps (finished = false).
  std::function<PeerResult(const model::Scenario& scenario, double tolerance, long max_steps)> run;
};

/// SUNDIALS' CVODE, Adams and BDF, re-initialised at every switch.
std::vector<BenchPeer> cvode_peers();

/// Dormand-Prince 5(4), Runge-Kutta-Fehlberg 7(8) and Bulirsch-Stoer of Boost.odeint, begun anew in every
/// segment of constant friction; CVODE where this build has it.
std::vector<BenchPeer> library_peers();

/// "SUNDIALS" where this build was made without it, else empty.
std::string missing_library();

}  // namespace tribotrack::bench
