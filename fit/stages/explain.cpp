#include "fit/stages/explain.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fit/checks/runs.h"

namespace tribotrack::fit::internal {

namespace {

constexpr double kUsual = 0.05;  ///< of friction, from run to run

/// Friction that differs from run to run. It takes the minimum with it, which is looked for from where the
/// fit and its search ended, among runs whose friction may differ by 5 %, then by as much as it does, while
/// that is likelier. Nothing where it goes with the setting: that is a law.
std::optional<ExplainedProblem> by_scatter(const Problem& problem, const Estimation& fit,
                                           const FitOptions& options) {
  constexpr std::size_t kMostMinima = 6;
  constexpr int kMostTimes = 4, kOwnErrors = 2;
  std::optional<ExplainedProblem> best;
  const auto with_scatter = [&](double relative, bool together, const Eigen::VectorXd& values) {
    const auto of = [&](FitParameter parameter) { return fit.unknowns().value_of(parameter, values); };
    Problem next =
        with_run_scatter(problem, relative, together, of(FitParameter::mu1), of(FitParameter::mu2));
    for (const FitParameter parameter : problem.free) next.start[parameter] = of(parameter);
    return next;
  };
  /// Descends; whether that is likelier than the best so far, which it is then.
  const auto descend = [&](Residuals& rows, Eigen::VectorXd z) {
    for (int k = 0; k < kOwnErrors; ++k) {  // which depend on where they are
      rows.set_own_errors(rows.unknowns().values(z));
      z = minimise(rows, z).z;
    }
    const Eigen::VectorXd values = rows.unknowns().values(z);
    const auto found = fit.scatter_at(values);
    if (!found || (best && found->first.chi2_fall <= best->found.chi2_fall)) return false;
    const auto& [explanation, scatter] = *found;
    best = {explanation, with_scatter(scatter.relative, scatter.together, values), values};
    return true;
  };
  const auto rows_of = [&](const Unknowns& unknowns) {
    Residuals rows(unknowns, options.threads);
    rows.set_tolerance(1e-8);
    rows.set_own_errors(unknowns.first_guess());
    return rows;
  };
  const Problem usual = with_scatter(kUsual, false, fit.values());
  const Unknowns unknowns(usual);
  Residuals rows = rows_of(unknowns);
  std::vector<Eigen::VectorXd> ends = fit.ends();
  ends.resize(std::min(kMostMinima, ends.size()));
  for (const Eigen::VectorXd& z : ends) descend(rows, z);
  bool likelier = best.has_value();
  for (int k = 0; likelier && k < kMostTimes; ++k) {
    const Problem next = best->problem;
    const Unknowns of_next(next);
    Residuals there = rows_of(of_next);
    likelier = descend(there, of_next.z(best->values));
  }
  return best;
}

/// Takes friction that differs from run to run for the explanation, or for one as good, where it is likelier
/// than what was found.
void weigh_scatter(const Problem& problem, const Estimation& fit, const FitOptions& options,
                   Explained& result) {
  constexpr double kBelow = 0.2, kAnyway = 20;  ///< of the gain of what was found; to first order
  const auto scatter =
      std::ranges::find(result.list, "run_scatter", [](const auto& e) { return e.found.name; });
  if (problem.counts_run_scatter() || problem.has_driven_tracks() || scatter == result.list.end() ||
      (result.quoted && result.quoted->under.size() > 1))
    return;
  const double known = result.quoted ? gain_of(result.list.front().found) : 0;
  if (known - gain_of(scatter->found) > std::max(kBelow * known, kAnyway)) return;
  auto found = by_scatter(problem, fit, options);
  if (!found) return;
  result.list.erase(scatter);
  const double gain = gain_of(found->found);
  const auto place =
      std::ranges::find_if(result.list, [&](const auto& e) { return gain_of(e.found) < gain; });
  const bool explains = found->found.explains;
  if (!explains || (result.quoted && gain < known + kPreferred)) {
    if (explains && gain > known - kPreferred) result.quoted->as_good.push_back(found->found);
    const bool behind_first = result.quoted && !result.list.empty();
    result.list.insert(behind_first ? std::max(place, result.list.begin() + 1) : place, std::move(*found));
    return;
  }
  result.quoted = Quoted{found->problem, {sentence_of(found->found)}, {}};
  result.list.insert(result.list.begin(), std::move(*found));
}

std::string text_of_bad_run(const std::string& run) {
  return "run '" + run + "' left out: it contradicts the others";
}

Quoted without_bad_runs(Problem problem, const std::vector<Outlier>& outliers) {
  Quoted quoted;
  for (SummaryRun& run : problem.summary_runs)
    run.held_out |= std::ranges::any_of(outliers, [&](const Outlier& o) { return o.run == run.name; });
  for (const Outlier& outlier : outliers) quoted.under.push_back(text_of_bad_run(outlier.run));
  quoted.problem = std::move(problem);
  return quoted;
}

/// Of unequal amplitudes one is as given: nobody said which, and with the other half of their ratio is wrong.
void doubt_amplitude(double ratio, Problem& problem) {
  const double half = 0.5 * std::abs(ratio) * Unknowns(problem).as_given(FitParameter::amplitude);
  const auto known = std::ranges::find(problem.conditions, FitParameter::amplitude, &Condition::quantity);
  if (known != problem.conditions.end())
    known->sd = std::hypot(known->sd, half);
  else
    problem.conditions.push_back({FitParameter::amplitude, half, "which of the two it is"});
}

/// The explanation's problem, begun at what it makes of the parameters.
Problem begun(const ExplainedProblem& explanation) {
  Problem problem = explanation.problem;
  if (explanation.found.name == "amplitude_ratio") doubt_amplitude(0.01 * explanation.found.size, problem);
  for (const auto& [parameter, under] : explanation.found.parameters)
    problem.start[parameter] = under.estimate;
  return problem;
}

auto first_that_explains(std::vector<ExplainedProblem>& list) {
  return std::ranges::find_if(list, [](const ExplainedProblem& e) { return e.found.explains; });
}

/// What explains the residuals of `fit`: one thing, or a second and a third beside it where each gains. A
/// large effect pulls the minimum so far that no descent leads from there to its own: where nothing in `list`
/// explains the residuals, the best is fitted anew, and told as it is then. Where these fits ended is added
/// to `ends`.
std::optional<Quoted> explained(const Problem& problem, const Estimation& fit, const FitOptions& options,
                                std::vector<ExplainedProblem>& list, std::vector<Eigen::VectorXd>& ends) {
  constexpr int kMostTogether = 3;
  Quoted quoted;
  double chi2 = fit.chi2();
  std::vector<ExplainedProblem> beside;
  for (int k = 0; k < kMostTogether; ++k) {
    std::vector<ExplainedProblem>& now = k == 0 ? list : beside;
    if (k == 0 && first_that_explains(now) == now.end() && !fit.outliers().empty())
      return without_bad_runs(problem, fit.outliers());
    std::optional<FitResult> best;
    std::vector<ExplainedProblem> left;  // that explain what it leaves
    const auto front = std::ranges::find_if(now, [](const auto& e) { return e.found.name != "run_scatter"; });
    if (first_that_explains(now) == now.end() && front != now.end() && front->found.refitted) {
      Explanation& found = front->found;
      const Problem next = begun(*front);
      Estimation there(next, options);
      there.find_minimum();
      ends.push_back(there.values_for(fit));
      best = there.assumed();
      if (!(best->p_value > kExplained)) left = there.explanations();
      if (best->chi2 < chi2 - found.chi2_fall) {
        found.chi2_fall = chi2 - best->chi2;
        found.p_after = best->p_value;
        found.parameters = best->as_assumed;
        found.explains = best->p_value > kExplained;
      }
    }
    if (const auto answer = first_that_explains(now); answer != now.end()) {
      std::rotate(now.begin(), answer, answer + 1);
      const Explanation& first = now.front().found;
      quoted.under.push_back(sentence_of(first));
      quoted.problem = begun(now.front());
      for (auto other = now.begin() + 1; other != now.end(); ++other)
        if (other->found.explains && now.front().gain - other->gain < kPreferred) {
          quoted.as_good.push_back(other->found);
          quoted.under.back() += " or " + sentence_of(other->found);
        }
      return quoted;
    }
    if (!best) return std::nullopt;
    quoted.under.push_back(sentence_of(front->found));
    chi2 = best->chi2;
    beside = std::move(left);
  }
  return std::nullopt;
}

}  // namespace

Explained explain(const Problem& problem, Estimation& fit, const FitOptions& options) {
  Explained result;
  const bool squares = options.loss == Loss::squares;  // robust weights are an answer of their own
  constexpr int kMostTimes = 2;
  bool again = true;
  for (int k = 0; again && k < kMostTimes; ++k) {
    std::vector<Eigen::VectorXd> ends;
    result = {fit.explanations(), std::nullopt};
    for (const ExplainedProblem& explanation : result.list)
      if (explanation.values.size() > 0) ends.push_back(explanation.values);
    if (fit.rejected() && squares) result.quoted = explained(problem, fit, options, result.list, ends);
    again = k + 1 < kMostTimes && fit.rejected() && fit.lower_from(ends);
  }
  if (fit.rejected() && squares) weigh_scatter(problem, fit, options, result);
  return result;
}

namespace {

/// What tracks moved: how well that is described, and the run that contradicts the others most.
struct Ends {
  double chi2 = 0, dof = 0;
  std::string worst;
  double drop = 0;  ///< of chi^2 without it, to first order
};

Ends ends_of(const Problem& problem, const FitOptions& options) {
  const Problem moved = by_displacements(problem);
  Estimation fit(moved, options);
  fit.find_minimum();
  const auto [worst, drop] = fit.worst();
  return {fit.chi2(), static_cast<double>(fit.degrees_of_freedom()), moved.summary_runs[worst].name, drop};
}

/// Tracks that contradict the others by what they moved, though friction may differ from run to run, one by
/// one; each time the minimum is looked for anew, as one bad run may drag it far.
void leave_out_bad_runs(Quoted& under, std::vector<ExplainedProblem>& list, const auto& with_scatter,
                        const FitOptions& options) {
  const Problem moved = by_displacements(under.problem);
  const double runs = static_cast<double>(moved.summary_runs.size());
  if (runs == 0) return;
  const auto unlikely = [&](double drop, double rest, double dof) {
    return runs * chance_of_run(drop, std::max(0.0, rest), dof);
  };
  Ends all = ends_of(with_scatter(kUsual), options);
  while (static_cast<double>(list.size() + 1) <= runs / 4 &&
         unlikely(all.drop, all.chi2 - all.drop, all.dof - 2) < 10 * kOutlier) {
    Problem before = under.problem;
    const auto is_worst = [&](const auto& run) { return run.name == all.worst; };
    if (std::erase_if(under.problem.trajectory_runs, is_worst) == 0) return;
    SummaryRun left_out = *std::ranges::find_if(moved.summary_runs, is_worst);
    left_out.held_out = true;
    under.problem.summary_runs.push_back(std::move(left_out));
    Ends others = ends_of(with_scatter(kUsual), options);
    if (!(unlikely(all.chi2 - others.chi2, others.chi2, others.dof) < kOutlier)) {
      under.problem = std::move(before);
      return;
    }
    under.under.push_back(text_of_bad_run(all.worst) + "; check its phi, dtau and label");
    Explanation bad_run;
    bad_run.name = "bad_run", bad_run.run = all.worst, bad_run.dof = 2;
    bad_run.size = std::sqrt(all.chi2 - others.chi2), bad_run.size_sd = 1, bad_run.unit = "sd";
    list.push_back({std::move(bad_run), {}, {}});
    all = std::move(others);
  }
}

}  // namespace

Explained explain_tracks(const Problem& problem, const Estimation& fit, const FitOptions& options) {
  if (!problem.has_driven_tracks() || !fit.rejected()) return {};
  Explained result;
  Quoted under{problem, {}, {}};
  const auto with_scatter = [&](double relative) {
    return with_run_scatter(under.problem, relative, false, fit.roughly(FitParameter::mu1),
                            fit.roughly(FitParameter::mu2));
  };
  leave_out_bad_runs(under, result.list, with_scatter, options);
  const Problem left = under.problem;
  std::optional<Estimation> others;
  if (!under.under.empty()) {
    others.emplace(left, options);
    others->find_minimum();
    others->test_residuals();
    under.problem.start = others->estimates_alone();
    for (ExplainedProblem& bad_run : result.list) bad_run.found = others->as_explanation(bad_run.found, fit);
    if (others->by_tracking()) result.quoted = under;
    if (!others->rejected()) return result;
  }
  const Estimation& alike = others ? *others : fit;
  const Problem wide = with_scatter(kUsual);
  Estimation apart(wide, options);
  apart.find_minimum();
  apart.test_residuals();
  if (apart.rejected()) return result;
  under.problem = with_scatter(apart.scatter_of_friction());
  // Two numbers of each run follow a drift of its points as well.
  const Estimation scattered(under.problem, options);
  if (!(scattered.log_likelihood(apart.values_for(scattered)) >
        alike.log_likelihood(alike.values()) + kPreferred / 2))
    return result;
  under.problem.start = apart.estimates_alone();
  Explanation scatter = apart.as_explanation(
      scatter_of(100 * apart.scatter_of_friction(), under.problem.trajectory_runs.size()), fit);
  under.under.push_back(sentence_of(scatter));
  result.list.push_back({std::move(scatter), {}, {}});
  result.quoted = std::move(under);
  return result;
}

}  // namespace tribotrack::fit::internal
