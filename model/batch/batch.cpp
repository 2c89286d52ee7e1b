#include "model/batch.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <exception>
#include <mutex>
#include <optional>
#include <utility>

#include "model/batch/lane_pool.h"
#include "model/parallel.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace internal {
namespace {

/// One run by the scalar integrator.
BatchEnd scalar_solution(const Scenario& scenario, const BatchOptions& asked, const EndRun*) {
  IntegrationOptions options;
  options.dense = false;
  if (asked.tolerance > kLaneTolerance) options.tolerance = asked.tolerance;
  const Trajectory trajectory = integrate(scenario, options);
  return end_at(trajectory.end().position, trajectory.end_time());
}

BatchSteady scalar_solution(const Scenario& scenario, const BatchOptions&, const OrbitRun*) {
  const auto orbit = steady_orbit(scenario);
  if (!orbit)
    throw InvalidParameter(
        "no unique steady motion exists: no friction in the cycle, or tilt beyond the friction angle");
  return steady_with(orbit->drift, scenario.drive.angular_frequency);
}

/// All runs of one kind on all threads.
template <class Run, bool kNeighbours, class Solution>
class Crew {
 public:
  /// `done`, of `total`, counts the solutions of all kinds.
  Crew(const std::function<Scenario(std::size_t)>& scenario_at, const BatchOptions& options,
       BatchOutcome& outcome, std::vector<Solution>& solutions, std::size_t& done, std::size_t total)
      : scenario_at_(scenario_at),
        options_(options),
        outcome_(outcome),
        solutions_(solutions),
        done_(done),
        total_(total) {}

  void run() {
    if (solutions_.empty()) return;
    const int threads = std::max(1, options_.threads);
    parallel_for(static_cast<std::size_t>(threads), threads, [this](std::size_t) {
      try {
        work();
      } catch (...) {
        next_ = solutions_.size();  // nobody begins anything more
        throw;
      }
    });
  }

 private:
  static constexpr std::size_t kPortion =
      32;  ///< so few that threads end together, so many that they seldom meet

  /// What one thread does.
  void work() {
    BatchSummary summary;
    LanePool<Run, kNeighbours> pool;
    std::size_t next = 0, end = 0, reported = 0;
    const auto source = [&]() -> std::optional<std::size_t> {
      if (next == end) {
        report(summary.solutions - std::exchange(reported, summary.solutions));
        next = std::min(next_.fetch_add(kPortion), solutions_.size());
        end = std::min(next + kPortion, solutions_.size());
      }
      return next < end ? std::optional(next++) : std::nullopt;
    };
    const auto begin = [&](Run& run, std::size_t number) {
      try {
        const Scenario scenario = scenario_at_(number);
        scenario.validate();
        return run.begin(scenario, options_);
      } catch (const std::exception& invalid) {
        refuse(number, BatchStatus::invalid, invalid.what());
        return Need::done;
      }
    };
    const auto settle = [&](const Run& run, std::size_t number, Need need) {
      Solution& solution = solutions_[number];
      if (solution.status == BatchStatus::invalid) {
      } else if (need == Need::done) {
        solution = run.result();
        ++summary.in_lanes;
      } else {
        solve_alone(number);
      }
      ++summary.solutions;
      summary.not_solved += solution.status != BatchStatus::done;
    };
    pool.work(source, begin, settle);
    report(summary.solutions - reported);
    add(summary);
  }

  void solve_alone(std::size_t number) {
    try {
      const Scenario scenario = scenario_at_(number);
      scenario.validate();
      try {
        solutions_[number] = scalar_solution(scenario, options_, static_cast<const Run*>(nullptr));
      } catch (const InvalidParameter& no_orbit) {
        refuse(number, BatchStatus::no_steady_motion, no_orbit.what());
      } catch (const StepLimitExceeded& no_end) {
        refuse(number, BatchStatus::too_long, no_end.what());
      } catch (const std::exception& failure) {
        refuse(number, BatchStatus::failed, failure.what());
      }
    } catch (const std::exception& invalid) {
      refuse(number, BatchStatus::invalid, invalid.what());
    }
  }

  void refuse(std::size_t number, BatchStatus status, const std::string& why) {
    solutions_[number].status = status;
    const std::lock_guard lock(mutex_);
    outcome_.reasons.emplace(number, why);
  }

  void report(std::size_t fresh) {
    if (!options_.progress || fresh == 0) return;
    const std::lock_guard lock(mutex_);
    options_.progress(done_ += fresh, total_);
  }

  void add(const BatchSummary& part) {
    const std::lock_guard lock(mutex_);
    BatchSummary& sum = outcome_.summary;
    sum.solutions += part.solutions;
    sum.in_lanes += part.in_lanes;
    sum.not_solved += part.not_solved;
  }

  const std::function<Scenario(std::size_t)>& scenario_at_;
  const BatchOptions& options_;
  BatchOutcome& outcome_;
  std::vector<Solution>& solutions_;
  std::size_t& done_;
  std::size_t total_;
  std::atomic<std::size_t> next_ = 0;
  std::mutex mutex_;
};

}  // namespace
}  // namespace internal

BatchOutcome solve_batch(std::size_t count, const std::function<Scenario(std::size_t)>& scenario_at,
                         const BatchOptions& options) {
  using namespace internal;
  BatchOutcome outcome;
  outcome.ends.resize(options.ends ? count : 0);
  outcome.steady.resize(options.steady ? count : 0);
  std::size_t done = 0;
  const std::size_t total = outcome.ends.size() + outcome.steady.size();
  Crew<EndRun, false, BatchEnd>(scenario_at, options, outcome, outcome.ends, done, total).run();
  Crew<OrbitRun, true, BatchSteady>(scenario_at, options, outcome, outcome.steady, done, total).run();
  return outcome;
}

BatchOutcome solve_batch(std::span<const Scenario> scenarios, const BatchOptions& options) {
  return solve_batch(
      scenarios.size(), [scenarios](std::size_t k) { return scenarios[k]; }, options);
}

std::string BatchSummary::brief_report() const {
  char text[200];
  std::snprintf(
      text, sizeof text, "%zu solutions, %.1f %% of them side by side, %zu not solved", solutions,
      100.0 * static_cast<double>(in_lanes) / static_cast<double>(std::max<std::size_t>(1, solutions)),
      not_solved);
  return text;
}

}  // namespace tribotrack::model
