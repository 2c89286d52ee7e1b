#include "fit/stages/explain.h"

#include <algorithm>
#include <utility>

#include "fit/checks/runs.h"

namespace tribotrack::fit::internal {

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
    if (fit.rejected() && squares)
      result.quoted = explained(problem, fit.chi2(), result.list, fit.outliers(), [&](const Problem& next) {
        Estimation there(next, options);
        there.find_minimum();
        ends.push_back(there.values_for(fit));
        const FitResult assumed = there.assumed();
        return Refit{assumed.chi2, assumed.p_value, assumed.as_assumed,
                     assumed.p_value > kExplained ? std::vector<ExplainedProblem>{} : there.explanations()};
      });
    again = k + 1 < kMostTimes && fit.rejected() && fit.lower_from(ends);
  }
  return result;
}

Explained explain_tracks(const Problem& problem, const Estimation& fit, const FitOptions& options) {
  constexpr double kUsual = 0.05;  ///< of friction, from run to run
  if (!problem.has_driven_tracks() || !fit.rejected()) return {};
  Quoted under{problem, {}, {}};
  const auto with_scatter = [&](double relative) {
    return with_run_scatter(under.problem, relative, fit.roughly(FitParameter::mu1),
                            fit.roughly(FitParameter::mu2));
  };
  const Problem ends = by_displacements(with_scatter(kUsual));
  Estimation by_ends(ends, options);
  by_ends.find_minimum();
  by_ends.test_residuals();
  Explained result = explain(ends, by_ends, options);
  std::erase_if(result.list,
                [](const ExplainedProblem& e) { return !(e.found.name == "bad_run" && e.found.explains); });
  std::vector<TrajectoryRun>& tracks = under.problem.trajectory_runs;
  if (result.quoted)
    for (const SummaryRun& run : result.quoted->problem.summary_runs)
      if (run.held_out &&
          std::erase_if(tracks, [&](const auto& track) { return track.name == run.name; }) > 0) {
        under.problem.summary_runs.push_back(run);
        under.under.push_back("run '" + run.name + "' left out: it contradicts the others");
      }
  result.quoted.reset();
  if (tracks.size() < problem.trajectory_runs.size()) {
    Estimation others(under.problem, options);
    others.find_minimum();
    others.test_residuals();
    if (!others.rejected()) {
      under.problem.start = others.estimates_alone();
      result.quoted = std::move(under);
      return result;
    }
  }
  const Problem wide = with_scatter(kUsual);
  Estimation apart(wide, options);
  apart.find_minimum();
  apart.test_residuals();
  if (apart.rejected()) return {};
  under.problem = with_scatter(apart.scatter_of_friction());
  under.problem.start = apart.estimates_alone();
  Explanation scatter = apart.scatter_explained(fit);
  under.under.push_back(sentence_of(scatter));
  result.list.push_back({std::move(scatter), {}, {}});
  result.quoted = std::move(under);
  return result;
}

}  // namespace tribotrack::fit::internal
