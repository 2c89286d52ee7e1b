#include "apps/bench/model.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "apps/bench/timing.h"
#include "model/plan.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using std::numbers::pi;

/// An explicit method that needs more than this has failed.
constexpr long kPatience = 300'000;
constexpr const char* kOurs = "tribotrack";

struct Scene {
  std::string name;
  Scenario scenario;
  /// False: explicit methods hang there, so the library's own result at its tightest tolerance is the
  /// reference instead of the independent one in extended precision.
  bool independent_reference = true;
};

std::vector<Scene> scenes_of(bool quick) {
  Scenario ordinary;
  ordinary.friction = {0.1, 0.0125, 0.5, pi / 2, 0};
  ordinary.cycles = quick ? 2 : 20;
  std::vector<Scene> scenes{{"always slipping", ordinary}};

  Scenario stick = ordinary;
  stick.friction.nominal = 0.122;
  stick.friction.reduced = 0.122 / 8;
  stick.friction.pulse_width = pi / 6;
  scenes.push_back({"stick in cycles", stick});

  Scenario marginal = ordinary;
  const double a = marginal.drive.amplitude * std::pow(marginal.drive.angular_frequency, 2);
  marginal.friction.nominal = a / marginal.drive.gravity / (1 + 1e-6);
  marginal.friction.reduced = marginal.friction.nominal / 8;
  scenes.push_back({"marginal", marginal, false});

  Scenario extreme = ordinary;
  extreme.friction.reduced = extreme.friction.nominal / 1e6;
  scenes.push_back({"extreme ratio", extreme});
  return scenes;
}

struct Method {
  std::string name, setting;
  std::function<PeerResult(const Scenario&)> run;
};

/// The end point, as of the others; repeating cycles are left out, as users get it.
Method ours(double tolerance) {
  IntegrationOptions options;
  options.tolerance = tolerance;
  options.dense = false;
  return {kOurs, fmt::format("tolerance {:g}", tolerance), [options](const Scenario& s) {
            const Trajectory trajectory = integrate(s, options);
            return PeerResult{trajectory.end().position, trajectory.end().velocity,
                              trajectory.summary().steps, true};
          }};
}

Method recipe(double tolerance, double max_step) {
  return {"paper's recipe", fmt::format("tolerance {:g}, steps up to {:g} s", tolerance, max_step),
          [=](const Scenario& s) { return paper_recipe(s, tolerance, max_step, kPatience); }};
}

std::vector<Method> methods_for(const Scene& scene, bool quick, const std::vector<BenchPeer>& peers) {
  std::vector<double> tight{1e-6, 1e-16}, tolerances{1e-6};
  if (!quick) {
    tight = {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15, 1e-16};
    tolerances.assign(tight.begin(), tight.end() - 1);
    // In the marginal scene an explicit method needs a million steps at most tolerances: a few are enough to
    // see it.
    if (!scene.independent_reference) tolerances = {1e-4, 1e-6, 1e-8};
  }
  std::vector<Method> methods;
  for (const double tolerance : tight) methods.push_back(ours(tolerance));
  for (const auto& [tolerance, step] : {std::pair(1e-6, 1e-4), {1e-6, 3e-4}, {1e-9, 1e-4}})
    if (!quick || tolerance > 1e-9) methods.push_back(recipe(tolerance, step));
  for (const BenchPeer& peer : peers)
    for (const double tolerance : tolerances)
      methods.push_back(
          {peer.name, fmt::format("tolerance {:g}", tolerance),
           [run = peer.run, tolerance](const Scenario& s) { return run(s, tolerance, kPatience); }});
  for (const double step : quick ? std::vector{1e-4} : std::vector{1e-4, 1e-5, 1e-6})
    methods.push_back({"Moreau-Jean", fmt::format("steps of {:g} s", step),
                       [step](const Scenario& s) { return moreau_jean(s, step); }});
  return methods;
}

Eigen::Vector2d reference_of(const Scene& scene) {
  if (scene.independent_reference) {
    const PeerResult result = extended_precision_reference(scene.scenario);
    if (result.finished) return result.position;
  }
  IntegrationOptions options;
  options.tolerance = 1e-17;
  return integrate(scene.scenario, options).end().position;
}

std::vector<ComparedRow> bench_scene(const Scene& scene, bool quick, const std::vector<BenchPeer>& peers) {
  const Eigen::Vector2d reference = reference_of(scene);
  const std::vector<Method> methods = methods_for(scene, quick, peers);
  std::vector<std::function<void()>> competitors;
  std::vector<ComparedRow> rows;
  for (const Method& method : methods) {
    // Who gave up at one tolerance is not asked for a tighter one.
    if (!rows.empty() && rows.back().method == method.name && !rows.back().arrived) continue;
    const PeerResult result = method.run(scene.scenario);
    ComparedRow row{scene.name,     scene.name,           method.name,
                    method.setting, method.name == kOurs, result.finished};
    row.error = (result.position - reference).norm();
    row.details = {{"steps", static_cast<double>(result.steps)}};
    rows.push_back(row);
    competitors.push_back([&method, &scene] { method.run(scene.scenario); });
  }
  const auto times = paired_medians(competitors, {quick ? 3 : 41, quick ? 0.02 : 0.25});
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].time = times[k].seconds;
    rows[k].details.push_back({"repetitions", static_cast<double>(times[k].repetitions)});
  }
  return rows;
}

ExtremeRow judge(const ExtremeCase& c) {
  ExtremeRow row;
  row.name = c.name;
  row.law = c.law.text;
  row.allowed = c.law.allowed;
  try {
    const Trajectory trajectory = integrate(c.scenario);
    const Sample end = trajectory.end();
    row.steps = trajectory.summary().steps;
    row.violation = c.law.violation(c.scenario, end.position);
    IntegrationOptions options;
    for (int p = 0; p <= static_cast<int>(Parameter::start_phase); ++p)
      options.derivatives.push_back(static_cast<Parameter>(p));
    const SensitiveSample differentiated = integrate(c.scenario, options).sensitive_end();
    row.derivatives_finite =
        differentiated.position_jacobian.allFinite() && differentiated.velocity_jacobian.allFinite();
    row.held = end.position.allFinite() && end.velocity.allFinite() && row.derivatives_finite &&
               row.violation <= row.allowed;
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

Comparison bench_model(const BenchOptions& options, const std::vector<BenchPeer>& peers) {
  Comparison comparison{"model",
                        "Error of the end point against run time",
                        "error of the end point",
                        "m",
                        "CPU time of a run",
                        "Runge-Kutta-Fehlberg 7(8) in extended precision (64-bit mantissa), segmented at the "
                        "friction switches, local tolerance 1e-17 of the scene's scales; in the marginal "
                        "scene, where explicit methods hang, tribotrack's own result at tolerance 1e-17",
                        1e-8};
  const auto scenes = scenes_of(options.quick);
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    const auto more = bench_scene(scenes[k], options.quick, peers);
    comparison.rows.insert(comparison.rows.end(), more.begin(), more.end());
    if (options.progress) options.progress(static_cast<int>(k) + 1, static_cast<int>(scenes.size()));
  }
  return comparison;
}

std::vector<ExtremeRow> bench_extremes(const BenchOptions& options) {
  const std::vector<ExtremeCase> cases = extreme_cases(options.quick);
  std::vector<ExtremeRow> rows;
  std::vector<std::function<void()>> competitors;
  for (const ExtremeCase& c : cases) {
    rows.push_back(judge(c));
    const bool failed = !rows.back().failure.empty();
    competitors.push_back([&c, failed] {
      if (!failed) integrate(c.scenario);
    });
    if (options.progress) options.progress(static_cast<int>(rows.size()), static_cast<int>(cases.size()));
  }
  const auto times = paired_medians(competitors, {options.quick ? 3 : 21, options.quick ? 0.01 : 0.1});
  const double ordinary = times.front().seconds / cycles_of(cases.front().scenario);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].time = times[k].seconds;
    rows[k].ratio_per_cycle = times[k].seconds / cycles_of(cases[k].scenario) / ordinary;
  }
  return rows;
}

namespace {

using Eigen::Vector2d;
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
  IntegrationOptions every_cycle, end_only;  // every cycle integrated, whether they repeat or not; no path
  every_cycle.reuse_repeating_cycles = end_only.dense = false;
  const Scenario smooth = base(0.1, 0, cycles), pulsed = base(0.1, pi / 2, cycles);
  Scenario useless = pulsed, ellipse = pulsed, tilted = pulsed;
  useless.friction.reduced = useless.friction.nominal;
  ellipse.drive.amplitude_y *= 1 + 1e-15;
  tilted.drive.tilt_x = 1e-20;
  pairs.push_back({"friction switches", "mu1 = mu2: edges that switch nothing", run(useless, every_cycle),
                   run(smooth, every_cycle)});
  pairs.push_back({"elliptic drive", "A_y = A (1 + 1e-15)", run(ellipse), run(pulsed)});
  pairs.push_back({"tilt", "tilt = 1e-20 rad", run(tilted), run(pulsed)});
  for (const double mu1 : {0.08, 0.1, 0.12}) {
    for (const double total : {cycles, 5 * cycles}) {
      const Scenario s = base(mu1, pi / 6, total);
      pairs.push_back({"every cycle", fmt::format("mu1 = {}, dtau = pi/6, {} cycles from rest", mu1, total),
                       run(s, every_cycle), run(s)});
    }
    Scenario steady = base(mu1, pi / 6, 1);
    steady.start = Start::steady;
    const double settling = cycles_until_repeating(steady_orbit(steady)->contraction);
    pairs.push_back({"transient",
                     fmt::format("mu1 = {}: a steady cycle, after {} from rest or directly", mu1, settling),
                     settled_cycle(steady, settling), run(steady)});
    const Scenario s = base(mu1, pi / 6, cycles);
    pairs.push_back({"dense output", fmt::format("mu1 = {}, dtau = pi/6: the whole motion or its end", mu1),
                     run(s), run(s, end_only)});
  }
  for (const int count : {3, 8, 15}) {
    IntegrationOptions options;
    for (int p = 0; p < count; ++p) options.derivatives.push_back(static_cast<Parameter>(p));
    pairs.push_back({"derivatives", fmt::format("mu1 = 0.1, dtau = pi/2: {} parameters or none", count),
                     run(pulsed, options), run(pulsed)});
  }
  return pairs;
}

}  // namespace

std::vector<OmissionRow> bench_omissions(const BenchOptions& options) {
  const std::vector<Pair> pairs = all_pairs(options.quick ? 16 : 20);
  const PairedTiming timing{options.quick ? 3 : 201, options.quick ? 0.01 : 0.2};
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
