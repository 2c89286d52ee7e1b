// Under what a fit is quoted whose data reject the model as it is described.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "fit/checks/explanations.h"

namespace tribotrack::fit::internal {

/// The problem that is quoted, and what it assumes that the one given does not.
struct Quoted {
  Problem problem;
  std::vector<std::string> under;
  std::vector<Explanation> as_good;  ///< others that explain the residuals as well
};

/// What explains the residuals: one thing, or a second and a third beside it where each gains. `list`: the
/// explanations of `problem`; `explanations_of`: those of another one. nullopt: nothing does.
std::optional<Quoted> explained(
    const Problem& problem, std::vector<ExplainedProblem> list, const std::vector<Outlier>& outliers,
    const std::function<std::vector<ExplainedProblem>(const Problem&)>& explanations_of);

/// The intervals cover what the explanations say that are as good.
void widen(const std::vector<Explanation>& as_good, FitResult& result);

}  // namespace tribotrack::fit::internal
