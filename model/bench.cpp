#include "model/bench.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "model/internal/paired_timing.h"
#include "model/peers.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

using std::numbers::pi;

/// An explicit method that needs more than this has failed; about a second.
constexpr long kPatience = 1'000'000;

struct Outcome {
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  long steps = 0;
  bool finished = true;
};

struct Method {
  ModelBenchRow row;
  std::function<Outcome()> run;
};

Method ours(const BenchScene& scene, double tolerance) {
  Method method;
  method.row.method = "tribotrack";
  method.row.ours = true;
  method.row.tolerance = tolerance;
  method.run = [s = scene.scenario, tolerance] {
    IntegrationOptions options;
    options.tolerance = tolerance;
    const Trajectory trajectory = integrate(s, options);
    return Outcome{trajectory.end().position, trajectory.summary().steps, true};
  };
  return method;
}

Outcome outcome_of(const PeerResult& result) {
  return {result.position, result.steps, result.finished};
}

Method peer(const BenchScene& scene, const std::string& name, DormandPrinceOptions options) {
  options.max_steps = kPatience;
  Method method;
  method.row.method = name;
  method.row.tolerance = options.relative_tolerance;
  method.row.max_step = options.max_step;
  method.run = [s = scene.scenario, options] { return outcome_of(dormand_prince(s, options)); };
  return method;
}

Method time_stepping(const BenchScene& scene, double step) {
  Method method;
  method.row.method = "Moreau-Jean";
  method.row.max_step = step;
  method.run = [s = scene.scenario, step] { return outcome_of(moreau_jean(s, step)); };
  return method;
}

std::vector<Method> methods_for(const BenchScene& scene, bool quick) {
  using List = std::vector<double>;
  std::vector<Method> methods;
  for (const double tolerance :
       quick ? List{1e-6, 1e-16}
             : List{1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14, 1e-15, 1e-16})
    methods.push_back(ours(scene, tolerance));
  methods.push_back(peer(scene, "paper's recipe", paper_recipe()));
  DormandPrinceOptions wider = paper_recipe();
  wider.max_step = 3e-4;
  methods.push_back(peer(scene, "paper's recipe", wider));
  DormandPrinceOptions tighter = paper_recipe();
  tighter.relative_tolerance = tighter.position_tolerance = tighter.velocity_tolerance = 1e-9;
  if (!quick) methods.push_back(peer(scene, "paper's recipe", tighter));
  // In the marginal scene an explicit method needs a million steps at most tolerances: one is enough to see
  // it.
  const bool stiff = !scene.independent_reference;
  for (const double tolerance : quick   ? List{1e-6}
                                : stiff ? List{1e-4, 1e-6, 1e-8}
                                        : List{1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14})
    methods.push_back(
        peer(scene, "Dormand-Prince segmented", segmented_dormand_prince(scene.scenario, tolerance)));
  for (const double step : quick ? List{1e-4} : List{1e-4, 1e-5, 1e-6})
    methods.push_back(time_stepping(scene, step));
  return methods;
}

Eigen::Vector2d reference_of(const BenchScene& scene, bool quick, std::string& how) {
  if (scene.independent_reference) {
    const double tolerance = quick ? 1e-15 : 1e-17;
    const PeerResult result = extended_precision_reference(scene.scenario, tolerance);
    if (result.finished) {
      how = quick ? "Dormand-Prince in extended precision at 1e-15"
                  : "Dormand-Prince in extended precision at 1e-17";
      return result.position;
    }
  }
  how = "tribotrack at its tightest tolerance (1e-17): explicit methods hang here";
  IntegrationOptions options;
  options.tolerance = 1e-17;
  return integrate(scene.scenario, options).end().position;
}

/// Who is faster where both reach the same error?
void compare(std::vector<ModelBenchRow>& rows) {
  for (ModelBenchRow& row : rows) {
    row.time_over_ours = std::numeric_limits<double>::quiet_NaN();
    if (row.ours || !row.finished) continue;
    double best = std::numeric_limits<double>::infinity();
    for (const ModelBenchRow& other : rows)
      if (other.ours && other.scene == row.scene && other.error <= row.error)
        best = std::min(best, other.time);
    row.time_over_ours = row.time / best;
  }
}

std::vector<ModelBenchRow> bench_scene(const BenchScene& scene, bool quick) {
  std::string how;
  const Eigen::Vector2d reference = reference_of(scene, quick, how);
  std::vector<Method> methods = methods_for(scene, quick);
  std::vector<std::function<void()>> competitors;
  std::vector<ModelBenchRow> rows;
  for (const Method& method : methods) {
    const Outcome outcome = method.run();
    ModelBenchRow row = method.row;
    row.scene = scene.name;
    row.reference = how;
    row.steps = outcome.steps;
    row.finished = outcome.finished;
    row.end = outcome.end;
    row.error = (outcome.end - reference).norm();
    rows.push_back(row);
    competitors.push_back([&method] { method.run(); });
  }
  internal::PairedTiming timing;
  timing.rounds = quick ? 3 : 41;
  timing.budget_s = quick ? 0.02 : 0.25;
  const auto times = internal::paired_medians(competitors, timing);
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
    const auto more = bench_scene(scene, options.quick);
    rows.insert(rows.end(), more.begin(), more.end());
    if (options.progress) options.progress(++done, static_cast<int>(scenes.size()));
  }
  compare(rows);
  return rows;
}

}  // namespace tribotrack::model
