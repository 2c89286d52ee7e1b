#include "apps/bench/model/batch.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <numbers>
#include <random>

#include "apps/bench/timing/paired_timing.h"
#include "model/batch.h"
#include "model/processor/instruction_set.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using std::numbers::pi;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Sweep {
  std::string name;
  double mu1_from, mu1_to, ratio_from, ratio_to;  ///< of mu2/mu1
};

const Sweep kSweeps[] = {
    {"mu1 = 0.02 .. 0.25, mu2 = 0.02 .. 1 mu1", 0.02, 0.25, 0.02, 1},
    {"always sliding: mu1 = 0.02 .. 0.11, mu2 = mu1/8", 0.02, 0.11, 0.125, 0.125},
    {"held before pulses: mu1 = 0.12 .. 0.25, mu2 = 0.02 .. 0.4 mu1", 0.12, 0.25, 0.02, 0.4},
};

std::vector<Scenario> scenarios_of(const Sweep& sweep, int count) {
  std::mt19937 generator(1);  // the same in every call
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(generator()) + 0.5) * 0x1p-32;
  };
  std::vector<Scenario> scenarios(static_cast<std::size_t>(count));
  for (Scenario& s : scenarios) {
    s.friction.nominal = uniform(sweep.mu1_from, sweep.mu1_to);
    s.friction.reduced = s.friction.nominal * uniform(sweep.ratio_from, sweep.ratio_to);
    s.friction.phase = uniform(0, 2 * pi);
    s.friction.pulse_width = uniform(0.05, 6.2);
  }
  return scenarios;
}

BatchOptions wanting(bool steady, bool lanes) {
  BatchOptions options;
  options.ends = !steady;
  options.steady = steady;
  options.lanes = lanes;
  return options;
}

double largest_difference(const BatchOutcome& a, const BatchOutcome& b, double amplitude) {
  double largest = 0;
  for (std::size_t k = 0; k < a.ends.size(); ++k)
    largest = std::max(largest, (a.ends[k].position - b.ends[k].position).norm());
  for (std::size_t k = 0; k < a.steady.size(); ++k)
    largest = std::max(largest, (a.steady[k].drift - b.steady[k].drift).norm());
  return largest / amplitude;
}

/// The lanes' work in an instruction set.
BatchOutcome in_set(model::internal::InstructionSet set, const std::vector<Scenario>& scenarios,
                    bool steady) {
  const auto best = model::internal::instruction_set();
  model::internal::use_instruction_set(set);
  BatchOutcome outcome = solve_batch(scenarios, wanting(steady, true));
  model::internal::use_instruction_set(best);
  return outcome;
}

std::vector<BatchBenchRow> compare(const Sweep& sweep, bool steady, bool quick) {
  const auto scenarios = scenarios_of(sweep, quick ? 50 : 1500);
  const double count = static_cast<double>(scenarios.size());
  const auto one_at_a_time = [&] { return solve_batch(scenarios, wanting(steady, false)); };
  const BatchOutcome scalar = one_at_a_time();
  std::vector<BatchBenchRow> rows;
  std::vector<std::function<void()>> competitors{[&] { one_at_a_time(); }};
  for (const auto set : model::internal::available_instruction_sets()) {
    const BatchOutcome lanes = in_set(set, scenarios, steady);
    BatchBenchRow row;
    row.sweep = sweep.name;
    row.wanted = steady ? "steady" : "ends";
    row.instruction_set = model::internal::to_string(set);
    row.scenarios = scenarios.size();
    row.in_lanes = static_cast<double>(lanes.summary.in_lanes) / count;
    row.full = static_cast<double>(lanes.summary.lane_steps) / static_cast<double>(lanes.summary.lane_slots);
    row.difference = largest_difference(lanes, scalar, scenarios.front().drive.amplitude);
    rows.push_back(row);
    competitors.push_back([&scenarios, set, steady] { in_set(set, scenarios, steady); });
  }
  PairedTiming timing;
  timing.rounds = quick ? 1 : 7;
  timing.budget_s = quick ? 0.05 : 2;
  const auto times = paired_medians(competitors, timing);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].time_scalar = times[0].seconds / count;
    rows[k].time_lanes = times[k + 1].seconds / count;
    rows[k].speedup = rows[k].time_scalar / rows[k].time_lanes;
    rows[k].million = rows[k].time_lanes * 1e6 / 2;
    rows[k].repetitions = times[k + 1].repetitions;
  }
  return rows;
}

/// alpha and v of the steady motion over mu1 and dtau, on two threads.
BatchBenchRow whole_sweep(bool quick) {
  const std::size_t side = quick ? 20 : 1000;
  const auto scenario_at = [side](std::size_t k) {
    const auto at = [side](std::size_t i, double from, double to) {
      return from + (to - from) * static_cast<double>(i) / static_cast<double>(side - 1);
    };
    Scenario s;
    s.friction.nominal = at(k / side, 0.02, 0.25);
    s.friction.reduced = s.friction.nominal / 8;
    s.friction.pulse_width = at(k % side, 0.05, 6.2);
    return s;
  };
  BatchOptions options = wanting(true, true);
  options.threads = 2;
  const auto begin = std::chrono::steady_clock::now();
  const BatchOutcome outcome = solve_batch(side * side, scenario_at, options);
  BatchBenchRow row;
  row.million = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  row.sweep = std::to_string(side) + " x " + std::to_string(side) +
              " measured, two threads: mu1 = 0.02 .. 0.25, dtau = 0.05 .. 6.2, mu2 = mu1/8";
  row.wanted = "steady";
  row.instruction_set = model::internal::to_string(model::internal::instruction_set());
  row.scenarios = side * side;
  row.in_lanes = static_cast<double>(outcome.summary.in_lanes) / static_cast<double>(row.scenarios);
  row.full =
      static_cast<double>(outcome.summary.lane_steps) / static_cast<double>(outcome.summary.lane_slots);
  row.time_scalar = row.time_lanes = row.speedup = row.difference = kNone;
  row.repetitions = 1;
  return row;
}

}  // namespace

std::vector<BatchBenchRow> bench_batch(const ModelBenchOptions& options) {
  std::vector<BatchBenchRow> rows;
  const int total = 2 * static_cast<int>(std::size(kSweeps)) + 1;
  int done = 0;
  const auto tell = [&] {
    if (options.progress) options.progress(++done, total);
  };
  for (const Sweep& sweep : kSweeps)
    for (const bool steady : {false, true}) {
      const auto more = compare(sweep, steady, options.quick);
      rows.insert(rows.end(), more.begin(), more.end());
      tell();
    }
  rows.push_back(whole_sweep(options.quick));
  tell();
  return rows;
}

}  // namespace tribotrack::bench
