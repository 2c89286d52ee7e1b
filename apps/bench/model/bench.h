// Error against run time of the friction model, ours and the methods of others, and its behaviour in stiff
// and extreme cases. Measurements of this machine now: the times, not the errors, change from call to call.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "apps/bench/peers/peer.h"

namespace tribotrack::bench {

struct ModelBenchOptions {
  bool quick = false;  ///< shorter runs, fewer tolerances and repetitions: a check that it works
  /// Besides the paper's recipe, our own Dormand-Prince and Moreau-Jean: what this build has of
  /// others (peers/library_peers.h).
  std::vector<BenchPeer> peers;
  std::function<void(int done, int total)> progress;
};

/// A scene of the comparison: 20 cycles from rest (2 when quick).
struct BenchScene {
  std::string name;
  model::Scenario scenario;
  /// False: explicit methods hang there, so the library's own result at its tightest tolerance is the
  /// reference instead of the independent one in extended precision.
  bool independent_reference = true;
};

/// Always slipping (mu1 = 0.1), stick in every cycle (mu1 = 0.122, dtau = pi/6), marginal
/// (a = mu1 g (1 + 1e-6)), extreme ratio (mu1/mu2 = 1e6).
std::vector<BenchScene> model_bench_scenes(bool quick);

/// One method at one setting on one scene.
struct ModelBenchRow {
  std::string scene;
  std::string method;
  bool ours = false;
  bool leaves_out = false;  ///< ours: repeating cycles are not integrated
  double tolerance = 0;     ///< 0 for fixed steps
  double max_step = 0;      ///< s, of fixed steps the step; 0 without limit
  long steps = 0;
  bool finished = true;
  Eigen::Vector2d end = Eigen::Vector2d::Zero();  ///< m
  double error = 0;                               ///< m, |end - reference|
  double path_error = 0;  ///< m, the largest |x - reference| after 1, 2, 5, 10 and all cycles
  double time = 0;        ///< s, CPU time, median of repetitions taken in turn with the others
  int repetitions = 0;
  std::string reference;
  /// Of a peer: its time over that of our fastest setting with no larger error, every cycle integrated. Below
  /// 1 the peer wins. 0: none of ours is as accurate, the peer wins by that; NaN for our own rows and
  /// unfinished ones.
  double time_over_ours = 0;
};

std::vector<ModelBenchRow> bench_model(const ModelBenchOptions& options = {});

/// One stiff or extreme scenario of extremes/extremes.h.
struct ModelExtremeRow {
  std::string name;
  bool finite = false;
  Eigen::Vector2d end = Eigen::Vector2d::Zero();  ///< m
  long steps = 0;
  int stops = 0;
  double time = 0;             ///< s, CPU time, median
  double ratio_per_cycle = 0;  ///< time per cycle over that of the ordinary case
  std::string invariant;       ///< the law that must hold
  double violation = 0;  ///< how far it is from holding, relative to the path unless the law says otherwise
  double allowed = 0;
  bool held = false;
  bool derivatives_finite = false;  ///< of the end point with respect to every parameter
  bool one_sided = false;           ///< and whether they are flagged as those of one side of a kink
  std::string failure;              ///< message of an exception
};

std::vector<ModelExtremeRow> bench_model_extremes(const ModelBenchOptions& options = {});

}  // namespace tribotrack::bench
