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

/// The explanation's problem, begun at what it makes of the parameters.
Problem begun(const ExplainedProblem& explanation) {
  Problem problem = explanation.problem;
  for (const auto& [parameter, under] : explanation.found.parameters)
    problem.start[parameter] = under.estimate;
  return problem;
}

auto first_that_explains(std::vector<ExplainedProblem>& list) {
  return std::ranges::find_if(list, [](const ExplainedProblem& e) { return e.found.explains; });
}

}  // namespace

std::optional<Quoted> explained(const Problem& problem, double chi2, std::vector<ExplainedProblem>& list,
                                const std::vector<Outlier>& outliers,
                                const std::function<Refit(const Problem&)>& refit) {
  constexpr int kMostTogether = 3;
  constexpr double kMost = 0.5;  ///< of chi^2, that one run makes
  Quoted quoted;
  std::vector<ExplainedProblem> beside;
  for (int k = 0; k < kMostTogether; ++k) {
    std::vector<ExplainedProblem>& now = k == 0 ? list : beside;
    if (k == 0 && first_that_explains(now) == now.end() && !outliers.empty())
      return without_bad_runs(problem, outliers);
    std::optional<Refit> best;
    for (std::size_t i = 0; i < now.size() && first_that_explains(now) == now.end(); ++i) {
      Explanation& found = now[i].found;
      const bool gross = found.name == "bad_run" && found.chi2_fall > kMost * chi2;
      if (!found.refitted || (i > 0 && !gross)) continue;
      Refit there = refit(begun(now[i]));
      if (there.chi2 < chi2 - found.chi2_fall) {
        found.chi2_fall = chi2 - there.chi2;
        found.p_after = there.p_value;
        found.parameters = there.parameters;
        found.explains = there.p_value > kExplained;
      }
      if (i == 0) best = std::move(there);
    }
    if (const auto answer = first_that_explains(now); answer != now.end()) {
      std::rotate(now.begin(), answer, answer + 1);
      const Explanation& first = now.front().found;
      quoted.under.push_back(sentence_of(first));
      quoted.problem = begun(now.front());
      for (auto other = now.begin() + 1; other != now.end(); ++other)
        if (other->found.explains && gain_of(first) - gain_of(other->found) < kPreferred)
          quoted.as_good.push_back(other->found);
      return quoted;
    }
    if (!best) return std::nullopt;
    quoted.under.push_back(sentence_of(now.front().found));
    chi2 = best->chi2;
    beside = std::move(best->explanations);
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
