// Many runs of the friction model at once: sweeps, multi-starts, predictions of experiments.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::model {

/// What became of one scenario.
enum class BatchStatus {
  done,
  invalid,           ///< a parameter out of its range
  no_steady_motion,  ///< none that is unique: no friction in the cycle, tilt beyond the friction angle
  too_long,          ///< not followed to its end within IntegrationOptions::max_steps
  failed,            ///< not solved; the reason is in BatchOutcome::reasons
};

/// The end of one run.
struct BatchEnd {
  BatchStatus status = BatchStatus::failed;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m, relative to the platform
  double alpha = 0;  ///< its direction, rad in [0, 2 pi); NaN where the part has not moved
  double v = 0;      ///< its length over the run's time, m/s
};

/// One cycle of the steady motion.
struct BatchSteady {
  BatchStatus status = BatchStatus::failed;
  Eigen::Vector2d drift = Eigen::Vector2d::Zero();  ///< displacement per cycle, m
  double alpha = 0;                                 ///< its direction, rad in [0, 2 pi); NaN without drift
  double v = 0;                                     ///< |drift| w / 2 pi, m/s
};

struct BatchOptions {
  bool ends = true;     ///< compute the end point of each run
  bool steady = false;  ///< compute each scenario's steady motion with pulses
  int threads = 1;      ///< results do not depend on it
  /// Of the velocity at every step of an end's run, in units of A w: 1e-14 leaves some 1e-13 of the path.
  /// Looser ones are faster; steady motions always come at full accuracy.
  double tolerance = 1e-14;
  /// Progress callback: solutions done and wanted. Called now and then, by one thread at a time.
  std::function<void(std::size_t done, std::size_t total)> progress;
};

/// What the batch did. Counts solutions: two per scenario where both ends and steady motions are wanted.
struct BatchSummary {
  std::size_t solutions = 0;
  std::size_t in_lanes = 0;    ///< solved side by side, the others one at a time
  std::size_t not_solved = 0;  ///< status other than done
  std::string brief_report() const;
};

struct BatchOutcome {
  std::vector<BatchEnd> ends;                  ///< in the order of the scenarios; empty unless wanted
  std::vector<BatchSteady> steady;             ///< likewise
  std::map<std::size_t, std::string> reasons;  ///< of scenarios that are not done
  BatchSummary summary;
};

/// Solves equation (5) of the paper for many scenarios: eight side by side in the processor's vectors, each
/// with its own step lengths and friction switches (a lane whose run has ended is given another), on several
/// threads that take scenarios from a common counter. Runs the lanes cannot carry - drives that are no
/// circle, steady motions at constant friction or to start from, starts and stops near the threshold of
/// friction, long creeping, cycles that hardly contract - are solved by integrate() and steady_orbit().
/// Results agree with those to 1e-11 of the path, and are the same to the last bit whatever the number of
/// threads and whichever scenarios share a vector. Nothing is thrown for a bad scenario: its status is
/// `invalid`, with the reason.
///   BatchOptions options;
///   options.threads = 4;
///   const auto outcome = solve_batch(scenarios, options);
///   if (outcome.ends[k].status == BatchStatus::done) use(outcome.ends[k].position);
BatchOutcome solve_batch(std::span<const Scenario> scenarios, const BatchOptions& options = {});

/// The same for scenarios made on demand, by any of the threads. An exception from `scenario_at` makes that
/// scenario `invalid`.
BatchOutcome solve_batch(std::size_t count, const std::function<Scenario(std::size_t)>& scenario_at,
                         const BatchOptions& options = {});

}  // namespace tribotrack::model
