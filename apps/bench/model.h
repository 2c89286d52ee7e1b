// Error against run time of the friction model, ours and the methods of others; its behaviour in stiff and
// extreme cases; what omissions save. Measurements of this machine now: the times, not the errors, change
// from call to call.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/bench/comparison.h"
#include "apps/bench/peers.h"

namespace tribotrack::bench {

struct ModelBenchOptions {
  bool quick = false;  ///< shorter runs, fewer tolerances and repetitions: a check that it works
  /// Besides the paper's recipe and Moreau-Jean.
  std::vector<BenchPeer> peers = library_peers();
  std::function<void(int done, int total)> progress;
};

/// 20 cycles from rest (2 when quick): always slipping (mu1 = 0.1), stick in every cycle (mu1 = 0.122, dtau =
/// pi/6), marginal (a = mu1 g (1 + 1e-6)), extreme ratio (mu1/mu2 = 1e6). The error is that of the end point,
/// m. Details: steps, repetitions.
Comparison bench_model(const ModelBenchOptions& options = {});

/// One stiff or extreme scenario of extremes.h.
struct ExtremeRow {
  std::string name;
  long steps = 0;
  double time = 0;             ///< s, CPU time, median
  double ratio_per_cycle = 0;  ///< time per cycle over that of the ordinary case
  std::string law;             ///< that must hold
  double violation = 0;  ///< how far it is from holding, relative to the path unless the law says otherwise
  double allowed = 0;
  bool held = false;                ///< and all is finite
  bool derivatives_finite = false;  ///< of the end point with respect to every parameter
  std::string failure;              ///< message of an exception
};

std::vector<ExtremeRow> bench_extremes(const ModelBenchOptions& options = {});

/// The same motion with and without a piece of machinery that it does not need. Medians of CPU times, the two
/// taken in turn.
struct OmissionRow {
  std::string omission;                                           ///< the stage's name in model/plan.h
  std::string scene;                                              ///< what is compared with what
  double time_with = 0;                                           ///< s
  double time_without = 0;                                        ///< s
  double error = 0;                                               ///< m, between the two end points
  double saving() const { return 1 - time_without / time_with; }  ///< below 0 where it costs
};

std::vector<OmissionRow> bench_omissions(const ModelBenchOptions& options = {});

}  // namespace tribotrack::bench
