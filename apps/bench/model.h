// Error against run time of the friction model, ours and the methods of others; its behaviour in stiff and
// extreme cases; what omissions save. Measurements of this machine now: the times, not the errors, change
// from call to call.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "apps/bench/comparison.h"
#include "apps/bench/peers.h"
#include "model/scenario.h"

namespace tribotrack::bench {

/// 20 cycles from rest (2 when quick): always slipping (mu1 = 0.1), stick in every cycle (mu1 = 0.122, dtau =
/// pi/6), marginal (a = mu1 g (1 + 1e-6)), extreme ratio (mu1/mu2 = 1e6). The error is that of the end point,
/// m. Details: steps, repetitions. `peers`: besides the paper's recipe and Moreau-Jean.
Comparison bench_model(const BenchOptions& options = {},
                       const std::vector<BenchPeer>& peers = library_peers());

// Stiff and extreme scenarios, each with a law that must hold there: one list for the benchmark's table and
// for the tests.

/// A statement about the end point of one scenario, and how far it is from holding.
struct ExtremeLaw {
  std::string text;
  double allowed = 0;  ///< of the violation, relative to the path unless the text says otherwise
  std::function<double(const model::Scenario&, const Eigen::Vector2d& end)> violation;
};

struct ExtremeCase {
  std::string name;
  model::Scenario scenario;
  ExtremeLaw law;
};

/// All of them, the ordinary case first. `quick`: 2 cycles each instead of 20 (100 instead of 1e6), the same
/// cases. Where a case exists for a part that always slips (mu1 = 0.1, dtau = pi/2) and for one that sticks
/// in every cycle (mu1 = 0.122, dtau = pi/6), both are there.
std::vector<ExtremeCase> extreme_cases(bool quick);

/// One of them, carried out.
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

std::vector<ExtremeRow> bench_extremes(const BenchOptions& options = {});

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

std::vector<OmissionRow> bench_omissions(const BenchOptions& options = {});

}  // namespace tribotrack::bench
