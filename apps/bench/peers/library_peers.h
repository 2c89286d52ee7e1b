// Solvers an engineer would use instead, run on eq. (5) of the paper, for `tribotrack bench model`
// only. They need libraries the product does not (Boost.odeint, SUNDIALS): a build without one of them lacks
// its solvers and names it in missing_libraries().
#pragma once

#include <string>
#include <vector>

#include "apps/bench/peers/peer.h"

namespace tribotrack::bench::peers {

/// How the switching friction is put before a smooth solver.
enum class Switching {
  by_clock,   ///< mu is evaluated at the time inside a step, as in the paper's recipe; never sticks
  segmented,  ///< a step ends on every switch and the next segment begins anew; stops and releases are seen
};

/// Dormand-Prince 5(4), Runge-Kutta-Fehlberg 7(8) and Bulirsch-Stoer of Boost.odeint, segmented and by clock;
/// where this processor has AVX2 and FMA, segmented once more compiled for them.
std::vector<BenchPeer> odeint_peers();

/// CVODE's Adams and BDF, re-initialised at every switch and by clock.
std::vector<BenchPeer> cvode_peers();

/// All solvers of this build.
std::vector<BenchPeer> all_peers();

/// The libraries this build was made without, such as "SUNDIALS"; empty where it has both.
std::vector<std::string> missing_libraries();

}  // namespace tribotrack::bench::peers
