// The table of stiff and extreme cases: each with a law that must hold there.
#include <cmath>
#include <limits>
#include <numbers>

#include "apps/bench/extremes/extremes.h"
#include "apps/bench/model/bench.h"
#include "apps/bench/timing/paired_timing.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using std::numbers::pi;

/// With respect to all fifteen parameters.
void judge_derivatives(const Scenario& scenario, ModelExtremeRow& row) {
  IntegrationOptions options;
  for (int p = 0; p <= static_cast<int>(Parameter::start_phase); ++p)
    options.derivatives.push_back(static_cast<Parameter>(p));
  const Trajectory trajectory = integrate(scenario, options);
  const SensitiveSample end = trajectory.sensitive_end();
  row.derivatives_finite = end.position_jacobian.allFinite() && end.velocity_jacobian.allFinite();
  row.one_sided = trajectory.summary().one_sided;
}

ModelExtremeRow judge(const ExtremeCase& c) {
  ModelExtremeRow row;
  row.name = c.name;
  row.invariant = c.law.text;
  row.allowed = c.law.allowed;
  try {
    const Trajectory trajectory = integrate(c.scenario);
    const Sample end = trajectory.end();
    row.end = end.position;
    row.finite = end.position.allFinite() && end.velocity.allFinite();
    row.steps = trajectory.summary().steps;
    row.stops = trajectory.summary().stops;
    row.violation = c.law.violation(c.scenario, end.position);
    judge_derivatives(c.scenario, row);
    row.held = row.finite && row.derivatives_finite && row.violation <= row.allowed;
  } catch (const std::exception& error) {
    row.failure = error.what();
    row.violation = std::numeric_limits<double>::infinity();
  }
  return row;
}

double cycles_of(const Scenario& s) {
  return s.end_time() * s.drive.angular_frequency / (2 * pi);
}

}  // namespace

std::vector<ModelExtremeRow> bench_model_extremes(const ModelBenchOptions& options) {
  const std::vector<ExtremeCase> cases = extreme_cases(options.quick);
  std::vector<ModelExtremeRow> rows;
  std::vector<std::function<void()>> competitors;
  for (const ExtremeCase& c : cases) {
    rows.push_back(judge(c));
    const bool failed = !rows.back().failure.empty();
    competitors.push_back([&c, failed] {
      if (!failed) integrate(c.scenario);
    });
    if (options.progress) options.progress(static_cast<int>(rows.size()), static_cast<int>(cases.size()));
  }
  PairedTiming timing;
  timing.rounds = options.quick ? 3 : 21;
  timing.budget_s = options.quick ? 0.01 : 0.1;
  const auto times = paired_medians(competitors, timing);
  const double ordinary = times.front().seconds / cycles_of(cases.front().scenario);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].time = times[k].seconds;
    rows[k].ratio_per_cycle = times[k].seconds / cycles_of(cases[k].scenario) / ordinary;
  }
  return rows;
}

}  // namespace tribotrack::bench
