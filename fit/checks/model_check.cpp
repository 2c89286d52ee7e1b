#include "fit/checks/model_check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "fit/checks/rivals.h"
#include "fit/checks/thinned.h"
#include "fit/minimum/multi_start.h"
#include "fit/rounding.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"
#include "fit/tools/track_part.h"

namespace tribotrack::fit::internal {
namespace {

using Kind = model::RivalLaw::Kind;

/// P(no more than `seen` runs among `up` and `down` signs), normal approximation.
double few_runs(int seen, double up, double down) {
  if (up < 4 || down < 4) return 1;
  const double n = up + down, mean = 1 + 2 * up * down / n;
  const double variance = (mean - 1) * (mean - 2) / (n - 1);
  return 0.5 * std::erfc(-(seen + 0.5 - mean) / std::sqrt(2 * variance));
}

struct Criteria {
  const Residuals& residuals;
  bool known_sigma;  ///< else the variance is what the residuals make it, for every model alike

  ModelComparison row(const std::string& name, double chi2, Eigen::Index parameters) const {
    ModelComparison row;
    row.name = name;
    row.chi2 = chi2;
    row.parameters = static_cast<int>(parameters);
    const double n = static_cast<double>(residuals.layout().rows()), k = static_cast<double>(parameters);
    const double misfit = known_sigma ? chi2 : n * std::log(chi2 / n);
    row.aic = misfit + 2 * k;
    row.bic = misfit + k * std::log(n);
    return row;
  }
};

std::string strength_text(Kind kind, const RivalFit& fit, double w) {
  const auto pm = [&](double unit) { return quoted(fit.strength * unit, fit.sd * unit); };
  switch (kind) {
    case Kind::stribeck:
      return "friction at rest higher by " + pm(100) + " %, fading by A w/4";
    case Kind::viscous:
      return "mu g + c |u| with c = " + pm(1) + " 1/s";
    default:
      return "each change of mu takes " + pm(1e3) + " ms (" +
             number(100 * fit.strength * w / (2 * std::numbers::pi), 2) + " % of a turn)";
  }
}

/// The first of `values` are the fitted parameters'.
std::map<FitParameter, double> fitted_values(const Unknowns& unknowns, const Eigen::VectorXd& values) {
  std::map<FitParameter, double> fitted;
  for (Eigen::Index i = 0; i < unknowns.reported(); ++i) fitted[unknowns.parameter(i)] = values(i);
  return fitted;
}

/// The fit with the tilt free, from the minimum without.
std::optional<ModelComparison> with_tilt(const Residuals& residuals, const Minimum& best,
                                         const Criteria& criteria) {
  const Unknowns& unknowns = residuals.unknowns();
  Problem problem = unknowns.problem();
  for (const FitParameter tilt : {FitParameter::tilt_x, FitParameter::tilt_y}) {
    problem.free.push_back(tilt);
    const model::Drive& drive = problem.summary_runs.empty() ? problem.trajectory_runs.front().scenario.drive
                                                             : problem.summary_runs.front().scenario.drive;
    problem.start[tilt] = tilt == FitParameter::tilt_x ? drive.tilt_x : drive.tilt_y;
  }
  const Eigen::VectorXd values = unknowns.values(best.z);
  for (Eigen::Index i = 0; i < unknowns.common(); ++i) problem.start[unknowns.parameter(i)] = values(i);
  const Unknowns tilted(problem);
  Residuals free(tilted);
  free.set_tolerance(1e-8);
  free.set_excess_variance(residuals.excess_variance());
  const Minimum minimum = minimise(free, tilted.z(tilted.first_guess()), {.held = {}, .decrement = 1e-4});
  if (!minimum.converged) return std::nullopt;
  ModelComparison row = criteria.row("tilt", minimum.chi2, tilted.size());
  const Eigen::VectorXd found = tilted.values(minimum.z);
  const double x = found(*tilted.find(FitParameter::tilt_x)), y = found(*tilted.find(FitParameter::tilt_y));
  row.values = fitted_values(unknowns, found);
  row.sentence = "tilt_x_rad = " + number(x) + ", tilt_y_rad = " + number(y);
  return row;
}

void conclude(FitResult& result) {
  const auto best = std::min_element(result.models.begin(), result.models.end(),
                                     [](const auto& a, const auto& b) { return a.aic < b.aic; });
  const ModelComparison& own = result.models.front();
  if (best == result.models.begin() || own.aic - best->aic < kPreferred) {
    result.left_out.push_back("No other model compared explains the data better (AIC).");
    return;
  }
  std::string text = "The data prefer the model with " + best->name + " (AIC lower by " +
                     number(own.aic - best->aic, 2) + ", BIC by " + number(own.bic - best->bic, 2) +
                     "; chi2 " + number(own.chi2) + " -> " + number(best->chi2) + "): " + best->sentence;
  text += best->name == "tilt" ? ". Add tilt_x_rad and tilt_y_rad to [fit] parameters, or level the platform."
                               : ". The numbers above hold for the paper's law only.";
  result.warnings.push_back(text);
}

bool any_pulse(const Problem& problem) {
  const auto pulses = [](const auto& run) { return run.scenario.friction.pulse_width > 0; };
  return std::any_of(problem.summary_runs.begin(), problem.summary_runs.end(), pulses) ||
         std::any_of(problem.trajectory_runs.begin(), problem.trajectory_runs.end(),
                     [&](const auto& run) { return !run.free_slide && pulses(run); });
}

/// The models one after the other, `best` being the paper's on the same data.
void compare_models(const Residuals& residuals, const Minimum& best, const FitOptions& options,
                    FitResult& result) {
  const Unknowns& unknowns = residuals.unknowns();
  const Problem& problem = unknowns.problem();
  const bool surprised = result.p_value < kSurprise, tracks = !problem.trajectory_runs.empty();
  Criteria criteria{residuals, true};
  // Tracks carry their correlated errors; one slide's tilt is part of its friction.
  const bool slides = problem.summary_runs.empty() &&
                      std::all_of(problem.trajectory_runs.begin(), problem.trajectory_runs.end(),
                                  [](const auto& run) { return run.free_slide; });
  const bool tilt_fitted =
      slides || unknowns.find(FitParameter::tilt_x) || unknowns.find(FitParameter::tilt_y);
  const auto tilted = tilt_fitted ? std::nullopt : with_tilt(residuals, best, criteria);
  const double lowest = tilted ? std::min(best.chi2, tilted->chi2) : best.chi2;
  const double dof = residuals.degrees_of_freedom();
  const bool explained = !tracks && chi2_survival(lowest, dof - 2) >= kSurprise;
  const bool spinning = std::any_of(problem.trajectory_runs.begin(), problem.trajectory_runs.end(),
                                    [](const auto& run) { return run.spin.has_value(); });
  const bool laws = options.rivals ||
                    (!tracks && !explained && result.runs_test_p_value < kAlike && result.outliers.empty());
  criteria.known_sigma = explained || !surprised || (tracks && chi2_survival(best.chi2, dof) >= kSurprise);
  result.models.push_back(criteria.row("Coulomb friction", best.chi2, unknowns.size()));
  if (tilted) {
    result.models.push_back(criteria.row("tilt", tilted->chi2, unknowns.size() + 2));
    result.models.back().sentence = tilted->sentence;
    result.models.back().values = tilted->values;
  }
  const auto at_rest = [](const auto& run) { return run.scenario.start == model::Start::rest; };
  const bool rest = std::all_of(problem.summary_runs.begin(), problem.summary_runs.end(), at_rest) &&
                    std::all_of(problem.trajectory_runs.begin(), problem.trajectory_runs.end(), at_rest);
  if (laws && rest && !spinning) {
    for (const Kind kind : {Kind::stribeck, Kind::viscous, Kind::rise_time}) {
      if (kind == Kind::rise_time && !any_pulse(problem)) continue;
      const RivalFit rival = fit_rival(residuals, best, kind, options.threads);
      if (!rival.converged) {
        result.left_out.push_back(std::string(to_string(kind)) +
                                  ": the fit under this law did not converge.");
        continue;
      }
      result.models.push_back(criteria.row(to_string(kind), rival.chi2, unknowns.size() + 1));
      result.models.back().values = fitted_values(unknowns, unknowns.values(rival.z));
      result.models.back().sentence = strength_text(kind, rival, unknowns.reference_frequency());
    }
  } else {
    result.left_out.push_back(
        spinning    ? "Alternative friction laws are not compared for parts that spin."
        : !rest     ? "Alternative friction laws are compared for runs that start at rest only."
        : explained ? "Alternative friction laws were not tried: tilt explains the residuals."
        : tracks    ? "Alternative friction laws were not compared for tracks: that takes "
                      "seconds; --compare-models does it."
                    : "Alternative friction laws were not tried: the residuals look like "
                      "scatter, not like a wrong law (runs test p = " +
                       number(result.runs_test_p_value, 2) + ").");
  }
  conclude(result);
}

}  // namespace

double runs_test(const Residuals& residuals, const Minimum& best) {
  const auto& runs = residuals.unknowns().problem().summary_runs;
  if (runs.size() < 8) return 1;
  struct Row {
    double width, phi, along, across;
  };
  std::vector<Row> rows;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Eigen::Vector2d difference = residuals.difference(best.at, i);
    const Eigen::Vector2d along = (runs[i].measured.vector - difference).normalized();
    const auto& friction = runs[i].scenario.friction;
    rows.push_back({friction.pulse_width, friction.phase, along.dot(difference),
                    along.x() * difference.y() - along.y() * difference.x()});
  }
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
    return std::tie(a.width, a.phi) < std::tie(b.width, b.phi);
  });
  double smallest = 1;
  for (double Row::*component : {&Row::along, &Row::across}) {
    int changes = 1, up = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      up += rows[i].*component > 0;
      if (i > 0 && (rows[i].*component > 0) != (rows[i - 1].*component > 0)) ++changes;
    }
    smallest = std::min(smallest, few_runs(changes, up, static_cast<double>(rows.size()) - up));
  }
  return std::min(1.0, 2 * smallest);  // of two components
}

void check_model(const Residuals& residuals, const Minimum& best, const FitOptions& options,
                 FitResult& result) {
  const Unknowns& unknowns = residuals.unknowns();
  const Problem& problem = unknowns.problem();
  const bool surprised = result.p_value < kSurprise;
  result.runs_test_p_value = runs_test(residuals, best);
  if (!surprised && !options.rivals) {
    result.left_out.push_back("Tilt and alternative friction laws were not tried: chi2 is no surprise (p = " +
                              number(result.p_value, 2) + ").");
    return;
  }
  if (problem.trajectory_runs.empty()) return compare_models(residuals, best, options, result);
  const Thinned few(residuals, best);
  if (!few.best().converged || few.best().at.empty()) return;
  compare_models(few.residuals(), few.best(), options, result);
  result.left_out.push_back(
      "Models were compared at no more than some hundred points of each track, their correlated errors "
      "counted.");
}

namespace {

constexpr std::size_t kMostPoints = 150;

std::size_t every_of(const TrajectoryRun& run) {
  return run.free_slide ? 1 : (run.track.time.size() + kMostPoints - 1) / kMostPoints;
}

Problem thinned(const Unknowns& unknowns, const Eigen::VectorXd& values) {
  Problem problem = unknowns.problem();
  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i) {
    TrajectoryRun& run = problem.trajectory_runs[i];
    run.track.exposure = 0;
    if (const NuisanceBlock* phase = unknowns.find(Nuisance::phase, i))
      run.scenario.start_phase += values(phase->first);
    run.start_phase_sd = 0;
    if (const NuisanceBlock* own = unknowns.find(Nuisance::own, i))
      for (std::size_t k = 0; k < run.own.parameters.size(); ++k)
        run.scenario.set(run.own.parameters[k], run.scenario.get(run.own.parameters[k]) +
                                                    values(own->first + static_cast<Eigen::Index>(k)));
    run.own = {};
    run.track = part_of(run.track, 0, run.track.time.size(), every_of(run));
  }
  return problem;
}

}  // namespace

Thinned::Thinned(const Residuals& residuals, const Minimum& best)
    : problem_(thinned(residuals.unknowns(), residuals.unknowns().values(best.z))),
      unknowns_(problem_),
      residuals_(unknowns_) {
  residuals_.set_tolerance(1e-8);
  // Scatter between points was estimated under the paper's law and would hide what that law misses.
  ExcessVariance scatter = residuals_.excess_variance();
  scatter.correlated = residuals.excess_variance().correlated;
  residuals_.set_excess_variance(scatter);
  const Unknowns& all = residuals.unknowns();
  best_ = minimise(residuals_, unknowns_.z(unknowns_.values_of(all, all.values(best.z))),
                   {.held = {}, .decrement = 1e-6});
}

}  // namespace tribotrack::fit::internal
