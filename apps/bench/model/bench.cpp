#include "apps/bench/model/bench.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "apps/bench/peers/baselines.h"
#include "apps/bench/timing/paired_timing.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using std::numbers::pi;

/// An explicit method that needs more than this has failed.
constexpr long kPatience = 300'000;

struct Outcome {
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  long steps = 0;
  bool finished = true;
};

struct Method {
  ModelBenchRow row;
  std::function<Outcome(const Scenario&)> run;
};

/// Every cycle integrated, or repeating ones left out. End points, as of the others.
Method ours(double tolerance, bool leaves_out) {
  Method method;
  method.row.method = leaves_out ? "tribotrack" : "tribotrack (every cycle)";
  method.row.ours = true;
  method.row.leaves_out = leaves_out;
  method.row.tolerance = tolerance;
  method.run = [tolerance, leaves_out](const Scenario& s) {
    IntegrationOptions options;
    options.tolerance = tolerance;
    options.dense = false;
    options.reuse_repeating_cycles = leaves_out;
    const Trajectory trajectory = integrate(s, options);
    return Outcome{trajectory.end().position, trajectory.summary().steps, true};
  };
  return method;
}

Outcome outcome_of(const PeerResult& result) {
  return {result.position, result.steps, result.finished};
}

Method peer(const std::string& name, DormandPrinceOptions options) {
  options.max_steps = kPatience;
  Method method;
  method.row.method = name;
  method.row.tolerance = options.relative_tolerance;
  method.row.max_step = options.max_step;
  method.run = [options](const Scenario& s) { return outcome_of(dormand_prince(s, options)); };
  return method;
}

Method peer(const BenchPeer& other, double tolerance) {
  Method method;
  method.row.method = other.name;
  method.row.tolerance = tolerance;
  method.run = [run = other.run, tolerance](const Scenario& s) {
    return outcome_of(run(s, tolerance, kPatience));
  };
  return method;
}

Method time_stepping(double step) {
  Method method;
  method.row.method = "Moreau-Jean";
  method.row.max_step = step;
  method.run = [step](const Scenario& s) { return outcome_of(moreau_jean(s, step)); };
  return method;
}

std::vector<Method> methods_for(const BenchScene& scene, const ModelBenchOptions& options) {
  const bool quick = options.quick;
  using List = std::vector<double>;
  std::vector<Method> methods;
  for (const bool leaves_out : {true, false})
    for (const double tolerance : quick ? List{1e-6, 1e-16}
                                        : List{1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12,
                                               1e-13, 1e-14, 1e-15, 1e-16})
      methods.push_back(ours(tolerance, leaves_out));
  methods.push_back(peer("paper's recipe", paper_recipe()));
  DormandPrinceOptions wider = paper_recipe();
  wider.max_step = 3e-4;
  methods.push_back(peer("paper's recipe", wider));
  DormandPrinceOptions tighter = paper_recipe();
  tighter.relative_tolerance = tighter.position_tolerance = tighter.velocity_tolerance = 1e-9;
  if (!quick) methods.push_back(peer("paper's recipe", tighter));
  // In the marginal scene an explicit method needs a million steps at most tolerances: one is enough to see
  // it.
  const bool stiff = !scene.independent_reference;
  const List tolerances =
      quick   ? List{1e-6}
      : stiff ? List{1e-4, 1e-6, 1e-8}
              : List{1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15};
  for (const BenchPeer& other : options.peers)
    for (const double tolerance : tolerances) methods.push_back(peer(other, tolerance));
  for (const double tolerance : tolerances)
    methods.push_back(peer("Dormand-Prince segmented", segmented_dormand_prince(scene.scenario, tolerance)));
  for (const double step : quick ? List{1e-4} : List{1e-4, 1e-5, 1e-6})
    methods.push_back(time_stepping(step));
  return methods;
}

/// Where the part is after some of its cycles, all of them last.
struct Reference {
  std::vector<int> cycles;
  std::vector<Eigen::Vector2d> ends;
  std::string how;
};

std::vector<int> looked_at(int cycles) {
  std::vector<int> list;
  for (const int k : {1, 2, 5, 10})
    if (k < cycles) list.push_back(k);
  list.push_back(cycles);
  return list;
}

Scenario first_cycles(Scenario scenario, int count) {
  scenario.cycles = count;
  return scenario;
}

Reference reference_of(const BenchScene& scene, bool quick) {
  Reference reference;
  reference.cycles = looked_at(static_cast<int>(scene.scenario.cycles));
  if (scene.independent_reference) {
    const double tolerance = quick ? 1e-15 : 1e-17;
    reference.how = quick ? "Dormand-Prince in extended precision at 1e-15"
                          : "Dormand-Prince in extended precision at 1e-17";
    for (const int k : reference.cycles) {
      const PeerResult result = extended_precision_reference(first_cycles(scene.scenario, k), tolerance);
      if (!result.finished) break;
      reference.ends.push_back(result.position);
    }
    if (reference.ends.size() == reference.cycles.size()) return reference;
    reference.ends.clear();
  }
  reference.how = "tribotrack at its tightest tolerance (1e-17): explicit methods hang here";
  IntegrationOptions options;
  options.tolerance = 1e-17;
  for (const int k : reference.cycles)
    reference.ends.push_back(integrate(first_cycles(scene.scenario, k), options).end().position);
  return reference;
}

/// The largest error after the cycles looked at. `end` is the run's own.
double path_error(const Method& method, const BenchScene& scene, const Reference& reference,
                  const Outcome& end) {
  double largest = (end.end - reference.ends.back()).norm();
  if (!end.finished) return largest;
  for (std::size_t k = 0; k + 1 < reference.ends.size(); ++k) {
    const Outcome early = method.run(first_cycles(scene.scenario, reference.cycles[k]));
    largest = std::max(largest, (early.end - reference.ends[k]).norm());
  }
  return largest;
}

/// Who is faster where both reach the same error?
void compare(std::vector<ModelBenchRow>& rows) {
  for (ModelBenchRow& row : rows) {
    row.time_over_ours = std::numeric_limits<double>::quiet_NaN();
    if (row.ours || !row.finished) continue;
    double best = std::numeric_limits<double>::infinity();
    for (const ModelBenchRow& other : rows)
      if (other.ours && !other.leaves_out && other.scene == row.scene && other.error <= row.error)
        best = std::min(best, other.time);
    row.time_over_ours = row.time / best;
  }
}

std::vector<ModelBenchRow> bench_scene(const BenchScene& scene, const ModelBenchOptions& options) {
  const bool quick = options.quick;
  const Reference reference = reference_of(scene, quick);
  const std::vector<Method> methods = methods_for(scene, options);
  std::vector<std::function<void()>> competitors;
  std::vector<ModelBenchRow> rows;
  for (const Method& method : methods) {
    // Who gave up at one tolerance is not asked for a tighter one.
    if (!rows.empty() && rows.back().method == method.row.method && !rows.back().finished) continue;
    const Outcome outcome = method.run(scene.scenario);
    ModelBenchRow row = method.row;
    row.scene = scene.name;
    row.reference = reference.how;
    row.steps = outcome.steps;
    row.finished = outcome.finished;
    row.end = outcome.end;
    row.error = (outcome.end - reference.ends.back()).norm();
    row.path_error = path_error(method, scene, reference, outcome);
    rows.push_back(row);
    competitors.push_back([&method, &scene] { method.run(scene.scenario); });
  }
  PairedTiming timing;
  timing.rounds = quick ? 3 : 41;
  timing.budget_s = quick ? 0.02 : 0.25;
  const auto times = paired_medians(competitors, timing);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].time = times[k].seconds;
    rows[k].repetitions = times[k].repetitions;
  }
  return rows;
}

}  // namespace

std::vector<BenchScene> model_bench_scenes(bool quick) {
  Scenario ordinary;
  ordinary.friction = {0.1, 0.0125, 0.5, pi / 2, 0};
  ordinary.cycles = quick ? 2 : 20;
  std::vector<BenchScene> scenes{{"always slipping", ordinary, true}};

  Scenario stick = ordinary;
  stick.friction.nominal = 0.122;
  stick.friction.reduced = 0.122 / 8;
  stick.friction.pulse_width = pi / 6;
  scenes.push_back({"stick in cycles", stick, true});

  Scenario marginal = ordinary;
  const double a = marginal.drive.amplitude * std::pow(marginal.drive.angular_frequency, 2);
  marginal.friction.nominal = a / marginal.drive.gravity / (1 + 1e-6);
  marginal.friction.reduced = marginal.friction.nominal / 8;
  scenes.push_back({"marginal", marginal, false});

  Scenario extreme = ordinary;
  extreme.friction.reduced = extreme.friction.nominal / 1e6;
  scenes.push_back({"extreme ratio", extreme, true});
  return scenes;
}

std::vector<ModelBenchRow> bench_model(const ModelBenchOptions& options) {
  std::vector<ModelBenchRow> rows;
  const auto scenes = model_bench_scenes(options.quick);
  int done = 0;
  for (const BenchScene& scene : scenes) {
    const auto more = bench_scene(scene, options);
    rows.insert(rows.end(), more.begin(), more.end());
    if (options.progress) options.progress(++done, static_cast<int>(scenes.size()));
  }
  compare(rows);
  return rows;
}

}  // namespace tribotrack::bench
