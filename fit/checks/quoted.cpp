#include "fit/checks/quoted.h"

#include <algorithm>
#include <utility>

#include "fit/checks/verdict.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit::internal {
namespace {

Quoted without_bad_runs(Problem problem, const std::vector<Outlier>& outliers) {
  Quoted quoted;
  for (SummaryRun& run : problem.summary_runs)
    run.held_out |= std::ranges::any_of(outliers, [&](const Outlier& o) { return o.run == run.name; });
  for (const Outlier& outlier : outliers)
    quoted.under.push_back("run '" + outlier.run + "' left out: it contradicts the others");
  quoted.problem = std::move(problem);
  return quoted;
}

}  // namespace

std::optional<Quoted> explained(
    const Problem& problem, std::vector<ExplainedProblem> list, const std::vector<Outlier>& outliers,
    const std::function<std::vector<ExplainedProblem>(const Problem&)>& explanations_of) {
  constexpr int kMostTogether = 3;
  Quoted quoted;
  for (int k = 0; k < kMostTogether; ++k) {
    const auto best = std::ranges::find_if(list, [](const auto& e) { return e.found.explains; });
    if (best != list.end()) {
      quoted.under.push_back(sentence_of(best->found));
      quoted.problem = best->problem;
      for (const auto& [parameter, under] : best->found.parameters)
        quoted.problem.start[parameter] = under.estimate;
      for (auto other = best + 1; other != list.end(); ++other)
        if (other->found.explains && gain_of(best->found) - gain_of(other->found) < kPreferred)
          quoted.as_good.push_back(other->found);
      return quoted;
    }
    if (k == 0 && !outliers.empty()) return without_bad_runs(problem, outliers);
    if (list.empty() || !list.front().found.refitted) return std::nullopt;
    quoted.under.push_back(sentence_of(list.front().found));
    Problem next = list.front().problem;
    for (const auto& [parameter, under] : list.front().found.parameters)
      next.start[parameter] = under.estimate;
    list = explanations_of(next);
  }
  return std::nullopt;
}

void widen(const std::vector<Explanation>& as_good, FitResult& result) {
  for (ParameterEstimate& p : result.parameters)
    for (const Explanation& other : as_good)
      if (const auto under = other.parameters.find(p.parameter); under != other.parameters.end()) {
        p.ci95.low = std::min(p.ci95.low, under->second.ci95.low);
        p.ci95.high = std::max(p.ci95.high, under->second.ci95.high);
        p.ci95_pieces = {p.ci95};
      }
}

}  // namespace tribotrack::fit::internal
