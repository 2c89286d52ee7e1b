// Under what a fit is quoted whose data reject the model as it is described, and what may be done with it.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "fit/checks/explanations.h"
#include "fit/fit_result.h"

namespace tribotrack::fit::internal {

/// The problem that is quoted, and what it assumes that the one given does not.
struct Quoted {
  Problem problem;
  std::vector<std::string> under;
  std::vector<Explanation> as_good;  ///< others that explain the residuals as well
};

/// A fit to another problem, from its screening on.
struct Refit {
  double chi2 = 0, p_value = 0;
  std::map<FitParameter, EstimateUnder> parameters;
  std::vector<ExplainedProblem> explanations;  ///< of what it leaves
};

/// What explains the residuals: one thing, or a second and a third beside it where each gains. `list`: the
/// explanations of `problem`, whose chi^2 is `chi2`. A large effect pulls the minimum so far that no descent
/// leads from there to its own: where nothing explains the residuals, the best is fitted anew, and told as it
/// is then. nullopt: nothing does.
std::optional<Quoted> explained(const Problem& problem, double chi2, std::vector<ExplainedProblem>& list,
                                const std::vector<Outlier>& outliers,
                                const std::function<Refit(const Problem&)>& refit);

/// The intervals cover what the explanations say that are as good.
void widen(const std::vector<Explanation>& as_good, FitResult& result);

/// Fills FitResult::verdict and verdict_reasons from all else that the result says. Not converged, not
/// identifiable, scatter that dominates, or chi^2 that rejects the model (p < 0.001 before any scatter was
/// added) and that nothing explains: do not use. Rejected, and explained by one thing or by what repeated
/// runs show: use with care. Other doubts likewise. Else: use.
void judge(FitResult& result);

/// From chi2, dof, p_value and scatter of a result.
Agreement agreement(const FitResult& result);

}  // namespace tribotrack::fit::internal
