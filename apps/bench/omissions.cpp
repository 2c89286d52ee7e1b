// What each omission of model/plan.h saves: pairs of the same motion, with and without the machinery.
#include <fmt/format.h>

#include <numbers>

#include "apps/bench/model.h"
#include "apps/bench/timing.h"
#include "model/plan.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using Eigen::Vector2d;
using std::numbers::pi;
using Work = std::function<Vector2d()>;  // returns an end point

struct Pair {
  const char* omission;
  std::string scene;
  Work with, without;
};

Scenario base(double mu1, double dtau, double cycles) {
  Scenario s;
  s.friction = {mu1, mu1 / 8, 0.5, dtau, 0};
  s.cycles = cycles;
  return s;
}

Work run(const Scenario& s, const IntegrationOptions& options = {}) {
  return [s, options]() -> Vector2d { return integrate(s, options).end().position; };
}

/// Every cycle integrated, whether they repeat or not.
Work cycle_by_cycle(const Scenario& s) {
  IntegrationOptions options;
  options.reuse_repeating_cycles = false;
  return run(s, options);
}

Work end_of_run(const Scenario& s) {
  IntegrationOptions options;
  options.dense = false;
  return run(s, options);
}

Work with_derivatives(const Scenario& s, int count) {
  IntegrationOptions options;
  for (int p = 0; p < count; ++p) options.derivatives.push_back(static_cast<Parameter>(p));
  return run(s, options);
}

/// A run that settles from rest, then one cycle.
Work settled_cycle(Scenario settling, double cycles) {
  settling.start = Start::rest;
  settling.cycles = cycles;
  return [settling]() -> Vector2d {
    Scenario last = settling;
    last.initial_velocity = integrate(settling).end().velocity;
    last.cycles = 1;
    return integrate(last).end().position;
  };
}

std::vector<Pair> all_pairs(double cycles) {
  std::vector<Pair> pairs;
  const Scenario smooth = base(0.1, 0, cycles), pulsed = base(0.1, pi / 2, cycles);
  Scenario useless = pulsed, ellipse = pulsed, tilted = pulsed;
  useless.friction.reduced = useless.friction.nominal;
  ellipse.drive.amplitude_y *= 1 + 1e-15;
  tilted.drive.tilt_x = 1e-20;
  pairs.push_back({"friction switches", "mu1 = mu2: edges that switch nothing", cycle_by_cycle(useless),
                   cycle_by_cycle(smooth)});
  pairs.push_back({"elliptic drive", "A_y = A (1 + 1e-15)", run(ellipse), run(pulsed)});
  pairs.push_back({"tilt", "tilt = 1e-20 rad", run(tilted), run(pulsed)});
  for (const double mu1 : {0.08, 0.1, 0.12}) {
    for (const double total : {cycles, 5 * cycles}) {
      const Scenario s = base(mu1, pi / 6, total);
      pairs.push_back({"every cycle", fmt::format("mu1 = {}, dtau = pi/6, {} cycles from rest", mu1, total),
                       cycle_by_cycle(s), run(s)});
    }
    Scenario steady = base(mu1, pi / 6, 1);
    steady.start = Start::steady;
    const double settling = cycles_until_repeating(steady_orbit(steady)->contraction);
    pairs.push_back({"transient",
                     fmt::format("mu1 = {}: a steady cycle, after {} from rest or directly", mu1, settling),
                     settled_cycle(steady, settling), run(steady)});
    const Scenario s = base(mu1, pi / 6, cycles);
    pairs.push_back({"dense output", fmt::format("mu1 = {}, dtau = pi/6: the whole motion or its end", mu1),
                     run(s), end_of_run(s)});
  }
  for (const int count : {3, 8, 15})
    pairs.push_back({"derivatives", fmt::format("mu1 = 0.1, dtau = pi/2: {} parameters or none", count),
                     with_derivatives(pulsed, count), run(pulsed)});
  return pairs;
}

}  // namespace

std::vector<OmissionRow> bench_omissions(const ModelBenchOptions& options) {
  const std::vector<Pair> pairs = all_pairs(options.quick ? 16 : 20);
  PairedTiming timing;
  timing.rounds = options.quick ? 3 : 201;
  timing.budget_s = options.quick ? 0.01 : 0.2;
  std::vector<OmissionRow> rows;
  for (const Pair& pair : pairs) {
    const auto times = paired_medians({[&] { pair.with(); }, [&] { pair.without(); }}, timing);
    rows.push_back({pair.omission, pair.scene, times[0].seconds, times[1].seconds,
                    (pair.with() - pair.without()).norm()});
    if (options.progress) options.progress(static_cast<int>(rows.size()), static_cast<int>(pairs.size()));
  }
  return rows;
}

}  // namespace tribotrack::bench
