// A method of others, as the benchmarks run it.
#pragma once

#include <functional>
#include <string>

#include "apps/bench/peers/baselines.h"

namespace tribotrack::bench {

/// A method of others that takes any tolerance, relative to the scene's own scales A and A w.
struct BenchPeer {
  std::string name;
  /// Gives up after max_steps (finished = false).
  std::function<PeerResult(const model::Scenario& scenario, double tolerance, long max_steps)> run;
};

}  // namespace tribotrack::bench
