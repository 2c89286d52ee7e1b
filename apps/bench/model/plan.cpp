#include "apps/bench/model/plan.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "apps/bench/timing/paired_timing.h"
#include "model/plan.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using Eigen::Vector2d;
using std::numbers::pi;
using Work = std::function<Vector2d()>;  // returns an end point

constexpr double kNotComparable = std::numeric_limits<double>::quiet_NaN();

struct Pair {
  PlanBenchRow row;
  Work with, without;
  bool same_motion = true;
};

Scenario base(double mu1, double dtau, double cycles) {
  Scenario s;
  s.friction = {mu1, mu1 / 8, 0.5, dtau, 0};
  s.cycles = cycles;
  return s;
}

Work run(const Scenario& s, int derivatives = 0) {
  IntegrationOptions options;
  for (int p = 0; p < derivatives; ++p) options.derivatives.push_back(static_cast<Parameter>(p));
  return [s, options]() -> Vector2d { return integrate(s, options).end().position; };
}

/// Every cycle integrated, whether they repeat or not.
Work cycle_by_cycle(const Scenario& s) {
  IntegrationOptions options;
  options.reuse_repeating_cycles = false;
  return [s, options]() -> Vector2d { return integrate(s, options).end().position; };
}

/// The end alone, every cycle integrated.
Work end_cycle_by_cycle(const Scenario& s) {
  IntegrationOptions options;
  options.reuse_repeating_cycles = options.dense = false;
  return [s, options]() -> Vector2d { return integrate(s, options).end().position; };
}

/// The end alone.
Work end_of(const Scenario& s) {
  IntegrationOptions options;
  options.dense = false;
  return [s, options]() -> Vector2d { return integrate(s, options).end().position; };
}

const PlanStage& stage(const std::vector<PlanStage>& stages, const std::string& name) {
  for (const PlanStage& s : stages)
    if (s.name == name) return s;
  throw std::logic_error("plan: no stage " + name);
}

class Pairs {
 public:
  /// `planned`: the scene without the machinery, whose plan predicts.
  void add(const std::string& omission, const std::string& scene, const Scenario& planned, Work with,
           Work without, bool same_motion = true, const PlanPurpose& purpose = {}) {
    const std::vector<PlanStage> stages = plan(planned, purpose);
    const PlanStage& s = stage(stages, omission);
    Pair pair;
    pair.row.omission = omission;
    pair.row.scene = scene;
    pair.row.error_bound = s.error_bound;
    pair.with = std::move(with);
    pair.without = std::move(without);
    pair.same_motion = same_motion;
    pairs_.push_back(std::move(pair));
  }
  std::vector<Pair>& all() { return pairs_; }

 private:
  std::vector<Pair> pairs_;
};

void add_machinery(Pairs& pairs, double cycles) {
  // Neighbours at the threshold: the same pulses, with and without a stop in each cycle.
  Scenario sliding = base(0.11, pi / 6, 1), sticking = base(0.12, pi / 6, 1);
  pairs.add("stick and release", "mu1 = 0.12 sticks, its neighbour 0.11 slides, dtau = pi/6, a cycle",
            sliding, run(sticking), run(sliding), false);

  Scenario smooth = base(0.1, 0, cycles), switched = base(0.1, pi / 2, cycles);
  pairs.add("friction switches", "mu1 = 0.1, pulses of dtau = pi/2 or none", smooth, cycle_by_cycle(switched),
            cycle_by_cycle(smooth), false);
  Scenario useless = switched;
  useless.friction.reduced = useless.friction.nominal;
  pairs.add("friction switches", "mu1 = mu2: edges that switch nothing", smooth, cycle_by_cycle(useless),
            cycle_by_cycle(smooth));

  Scenario slide = base(0.1, 0, cycles), shaken = slide;
  slide.drive.amplitude = slide.drive.amplitude_y = 0;
  slide.initial_velocity = shaken.initial_velocity = {0.3, 0.4};
  pairs.add("platform drive", "a free slide, platform at rest or shaken", slide, run(shaken), run(slide),
            false);

  Scenario circular = base(0.1, pi / 2, cycles), ellipse = circular;
  ellipse.drive.amplitude_y *= 1 + 1e-15;
  pairs.add("elliptic drive", "A_y = A (1 + 1e-15)", circular, run(ellipse), run(circular));
  Scenario tilted = circular;
  tilted.drive.tilt_x = 1e-20;
  pairs.add("tilt", "tilt = 1e-20 rad", circular, run(tilted), run(circular));
}

void add_repetition(Pairs& pairs, double cycles) {
  for (const double mu1 : {0.08, 0.1, 0.12}) {
    char text[80];
    for (const double total : {cycles, 5 * cycles}) {
      const Scenario s = base(mu1, pi / 6, total);
      std::snprintf(text, sizeof text, "mu1 = %g, dtau = pi/6, %g cycles from rest", mu1, total);
      pairs.add("every cycle", text, s, cycle_by_cycle(s), run(s));
    }
    // One cycle of the steady motion: by a run that settles, or directly.
    Scenario steady = base(mu1, pi / 6, 1);
    steady.start = Start::steady;
    const auto orbit = steady_orbit(steady);
    Scenario settling = steady;
    settling.start = Start::rest;
    settling.cycles = cycles_until_repeating(orbit->contraction);
    std::snprintf(text, sizeof text, "mu1 = %g: a steady cycle, after %g from rest or directly", mu1,
                  settling.cycles);
    pairs.add(
        "transient", text, steady,
        [settling]() -> Vector2d {
          Scenario last = settling;
          last.initial_velocity = integrate(settling).end().velocity;
          last.cycles = 1;
          return integrate(last).end().position;
        },
        run(steady));
    std::snprintf(text, sizeof text, "mu1 = %g: steady alpha and v, by %g cycles or directly", mu1, cycles);
    pairs.add(
        "transient", text, steady, end_cycle_by_cycle(base(mu1, pi / 6, cycles)),
        [steady]() -> Vector2d { return steady_orbit(steady)->drift; }, false);
  }
}

void add_dense_output(Pairs& pairs, double cycles) {
  for (const double mu1 : {0.08, 0.1, 0.12}) {
    char text[80];
    std::snprintf(text, sizeof text, "mu1 = %g, dtau = pi/6: the whole motion or its end", mu1);
    const Scenario s = base(mu1, pi / 6, cycles);
    pairs.add("dense output", text, s, run(s), end_of(s), true, {0, false});
  }
}

void add_derivatives(Pairs& pairs, double cycles) {
  const Scenario s = base(0.1, pi / 2, cycles);
  for (const int count : {3, 8, 15})
    pairs.add("derivatives", "mu1 = 0.1, dtau = pi/2: " + std::to_string(count) + " parameters or none", s,
              run(s, count), run(s));
}

}  // namespace

std::vector<PlanBenchRow> bench_plan(const ModelBenchOptions& options) {
  Pairs pairs;
  const double cycles = options.quick ? 16 : 20;
  add_machinery(pairs, cycles);
  add_repetition(pairs, cycles);
  add_dense_output(pairs, cycles);
  add_derivatives(pairs, cycles);
  PairedTiming timing;
  timing.rounds = options.quick ? 3 : 201;
  timing.budget_s = options.quick ? 0.01 : 0.2;
  std::vector<PlanBenchRow> rows;
  for (const Pair& pair : pairs.all()) {
    PlanBenchRow row = pair.row;
    row.error = pair.same_motion ? (pair.with() - pair.without()).norm() : kNotComparable;
    const auto times = paired_medians({[&] { pair.with(); }, [&] { pair.without(); }}, timing);
    row.time_with = times[0].seconds;
    row.time_without = times[1].seconds;
    row.repetitions = std::min(times[0].repetitions, times[1].repetitions);
    row.saving = 1 - row.time_without / row.time_with;
    rows.push_back(row);
    if (options.progress)
      options.progress(static_cast<int>(rows.size()), static_cast<int>(pairs.all().size()));
  }
  return rows;
}

}  // namespace tribotrack::bench
