#include "model/batch.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <exception>
#include <limits>
#include <mutex>
#include <optional>
#include <tuple>
#include <utility>

#include "model/alpha_v.h"
#include "model/batch/lane_pool.h"
#include "model/parallel.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace internal {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// One run by the scalar integrator.
BatchEnd scalar_solution(const Scenario& scenario, const BatchOptions& asked, const EndRun*, std::string&) {
  IntegrationOptions options;
  options.dense = false;
  if (asked.tolerance > kLaneTolerance) options.tolerance = asked.tolerance;
  const Trajectory trajectory = integrate(scenario, options);
  BatchEnd end;
  end.status = BatchStatus::done;
  end.position = trajectory.end().position;
  end.v = mean_velocity(end.position, trajectory.end_time());
  end.alpha = end.position.norm() > 0 ? displacement_angle(end.position) : kNone;
  return end;
}

BatchSteady scalar_solution(const Scenario& scenario, const BatchOptions&, const OrbitRun*,
                            std::string& why) {
  BatchSteady steady;
  const auto orbit = steady_orbit(scenario);
  if (!orbit) {
    steady.status = BatchStatus::no_steady_motion;
    why = "no unique steady motion exists: no friction in the cycle, or tilt beyond the friction angle";
    return steady;
  }
  steady.status = BatchStatus::done;
  steady.drift = orbit->drift;
  steady.v = orbit->mean_velocity(scenario.drive.angular_frequency);
  steady.alpha = steady.v > 0 ? orbit->alpha() : kNone;
  steady.contraction = orbit->contraction;
  return steady;
}

/// Whose turn it is, for all threads: portions that shrink with what is left (guided self-scheduling,
/// Polychronopoulos & Kuck 1987), so that threads seldom meet and end together with nothing to steal.
class Counter {
 public:
  Counter(std::size_t count, int threads) : count_(count), shares_(static_cast<std::size_t>(threads) * 16) {}
  /// [first, second) of the next portion; empty where none is left.
  std::pair<std::size_t, std::size_t> take() {
    std::size_t begin = next_, end = 0;
    do {
      if (begin >= count_) return {count_, count_};
      end = begin + std::clamp<std::size_t>((count_ - begin) / shares_, 1, kMost);
    } while (!next_.compare_exchange_weak(begin, end));
    return {begin, end};
  }
  void stop() { next_ = count_; }

 private:
  static constexpr std::size_t kMost = 64;
  std::size_t count_, shares_;
  std::atomic<std::size_t> next_ = 0;
};

/// Everything the threads share.
struct Work {
  std::size_t count;
  const std::function<Scenario(std::size_t)>& scenario_at;
  const BatchOptions& options;
  BatchOutcome& outcome;
  std::size_t total;
  std::mutex mutex;
  std::size_t done = 0;
  std::exception_ptr failure;
};

/// All runs of one kind on all threads.
template <class Run, bool kNeighbours, class Solution>
class Crew {
 public:
  Crew(Work& work, std::vector<Solution>& solutions)
      : work_(work), solutions_(solutions), counter_(work.count, work.options.threads) {
    solutions_.resize(work.count);
  }

  void run() {
    parallel_for(static_cast<std::size_t>(work_.options.threads), work_.options.threads,
                 [this](std::size_t) { one_thread(); });
    if (work_.failure) std::rethrow_exception(work_.failure);
  }

 private:
  struct Tally {
    BatchSummary summary;
    std::vector<std::pair<std::size_t, std::string>> reasons;
    std::size_t fresh = 0;  ///< since the last report
  };

  void one_thread() try {
    Tally tally;
    LanePool<Run, kNeighbours> pool;
    std::size_t next = 0, end = 0;
    const auto source = [&]() -> std::optional<std::size_t> {
      if (next == end) {
        std::tie(next, end) = counter_.take();
        report(tally);
      }
      if (next == end) return std::nullopt;
      return next++;
    };
    const auto begin = [&](Run& run, std::size_t number) {
      if (!work_.options.lanes) return Need::scalar;
      try {
        const Scenario scenario = work_.scenario_at(number);
        scenario.validate();
        if (scenario.spin.rate != 0) return Need::scalar;  // lanes know no spin
        return run.begin(scenario, work_.options);
      } catch (const std::exception& invalid) {
        solutions_[number].status = BatchStatus::invalid;
        tally.reasons.emplace_back(number, invalid.what());
        return Need::done;
      }
    };
    const auto settle = [&](const Run& run, std::size_t number, Need need) {
      Solution& solution = solutions_[number];
      ++tally.fresh;
      if (solution.status == BatchStatus::invalid) {
      } else if (need == Need::done) {
        solution = run.result();
        ++tally.summary.in_lanes;
      } else {
        ++tally.summary.by_scalar[static_cast<std::size_t>(run.reason)];
        solve_alone(number, solution, tally);
      }
      ++tally.summary.solutions;
      tally.summary.not_solved += solution.status != BatchStatus::done;
    };
    pool.work(source, begin, settle);
    tally.summary.lane_steps = pool.count().steps;
    tally.summary.lane_slots = pool.count().slots;
    report(tally);
    add(tally);
  } catch (...) {
    const std::lock_guard lock(work_.mutex);
    if (!work_.failure) work_.failure = std::current_exception();
    counter_.stop();
  }

  void solve_alone(std::size_t number, Solution& solution, Tally& tally) {
    std::string why;
    const auto refused = [&](BatchStatus status, const std::exception& reason) {
      solution.status = status;
      why = reason.what();
    };
    try {
      const Scenario scenario = work_.scenario_at(number);
      scenario.validate();
      try {
        solution = scalar_solution(scenario, work_.options, static_cast<const Run*>(nullptr), why);
      } catch (const InvalidParameter& no_orbit) {
        refused(BatchStatus::no_steady_motion, no_orbit);
      } catch (const StepLimitExceeded& no_end) {
        refused(BatchStatus::too_long, no_end);
      } catch (const std::exception& failure) {
        refused(BatchStatus::failed, failure);
      }
    } catch (const std::exception& invalid) {
      refused(BatchStatus::invalid, invalid);
    }
    if (solution.status != BatchStatus::done) tally.reasons.emplace_back(number, why);
  }

  void report(Tally& tally) {
    if (!work_.options.progress || tally.fresh == 0) return;
    const std::lock_guard lock(work_.mutex);
    work_.done += tally.fresh;
    tally.fresh = 0;
    work_.options.progress(work_.done, work_.total);
  }

  void add(const Tally& tally) {
    const std::lock_guard lock(work_.mutex);
    BatchSummary& sum = work_.outcome.summary;
    const BatchSummary& part = tally.summary;
    sum.solutions += part.solutions;
    sum.in_lanes += part.in_lanes;
    sum.not_solved += part.not_solved;
    sum.lane_steps += part.lane_steps;
    sum.lane_slots += part.lane_slots;
    for (std::size_t k = 0; k < kScalarReasons; ++k) sum.by_scalar[k] += part.by_scalar[k];
    work_.outcome.reasons.insert(tally.reasons.begin(), tally.reasons.end());
  }

  Work& work_;
  std::vector<Solution>& solutions_;
  Counter counter_;
};

}  // namespace
}  // namespace internal

BatchOutcome solve_batch(std::size_t count, const std::function<Scenario(std::size_t)>& scenario_at,
                         const BatchOptions& asked) {
  using namespace internal;
  BatchOptions options = asked;
  options.threads = std::max(1, options.threads);
  BatchOutcome outcome;
  const std::size_t wanted = (options.ends ? 1 : 0) + (options.steady ? 1 : 0);
  Work work{count, scenario_at, options, outcome, wanted * count, {}, 0, nullptr};
  if (options.ends) Crew<EndRun, false, BatchEnd>(work, outcome.ends).run();
  if (options.steady) Crew<OrbitRun, true, BatchSteady>(work, outcome.steady).run();
  return outcome;
}

BatchOutcome solve_batch(std::span<const Scenario> scenarios, const BatchOptions& options) {
  return solve_batch(
      scenarios.size(), [scenarios](std::size_t k) { return scenarios[k]; }, options);
}

const char* to_string(BatchStatus status) {
  switch (status) {
    case BatchStatus::done:
      return "done";
    case BatchStatus::invalid:
      return "invalid";
    case BatchStatus::no_steady_motion:
      return "no steady motion";
    case BatchStatus::too_long:
      return "too long";
    case BatchStatus::failed:
      break;
  }
  return "failed";
}

const char* to_string(ScalarReason reason) {
  switch (reason) {
    case ScalarReason::not_asked:
      return "lanes not asked for";
    case ScalarReason::drive:
      return "drive not circular";
    case ScalarReason::constant_friction:
      return "constant friction";
    case ScalarReason::start:
      return "starts on a steady motion";
    case ScalarReason::marginal:
      return "starts or stops near the threshold of friction";
    case ScalarReason::many_steps:
      return "creeps for long";
    case ScalarReason::weak_friction:
      return "friction so weak that cycles hardly contract";
    case ScalarReason::no_convergence:
      break;
  }
  return "Newton's method does not settle";
}

std::string BatchSummary::brief_report() const {
  char text[200];
  const double all = solutions > 0 ? 100.0 / static_cast<double>(solutions) : 0;
  const double used =
      lane_slots > 0 ? 100 * static_cast<double>(lane_steps) / static_cast<double>(lane_slots) : 0;
  std::snprintf(text, sizeof text,
                "%zu solutions, %.1f %% in lanes (which were %.0f %% full), %zu not solved", solutions,
                all * static_cast<double>(in_lanes), used, not_solved);
  return text;
}

std::string BatchSummary::full_report() const {
  std::string text = brief_report();
  for (std::size_t k = 0; k < kScalarReasons; ++k) {
    if (by_scalar[k] == 0) continue;
    char line[120];
    std::snprintf(line, sizeof line, "\n  one at a time: %zu (%s)", by_scalar[k],
                  to_string(static_cast<ScalarReason>(k)));
    text += line;
  }
  return text;
}

}  // namespace tribotrack::model
