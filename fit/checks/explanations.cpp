#include "fit/checks/explanations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>

#include "fit/checks/runs.h"
#include "fit/checks/score_tests.h"
#include "fit/minimum/multi_start.h"
#include "fit/rounding.h"
#include "fit/tools/thresholds.h"
#include "fit/variances/excess_variance.h"

namespace tribotrack::fit::internal {
namespace {

/// The worst of many runs is found by chance more easily.
double gain(const Explanation& found, std::size_t runs) {
  const double chosen = found.name == "bad_run" ? 2 * std::log(static_cast<double>(runs)) : 0;
  return gain_of(found) - chosen;
}

/// Runs that may be bad: the one without which chi^2 falls most, and the one of which that is true where the
/// model is taken to be good to a tenth only. For with small errors a bad run takes the minimum with it, and
/// others look worse there.
std::vector<std::size_t> suspects(const Residuals& residuals, const Minimum& best, bool rejected) {
  constexpr double kRough[] = {0.1};
  const Problem& problem = residuals.unknowns().problem();
  std::vector<bool> out;
  for (const SummaryRun& run : problem.summary_runs) out.push_back(run.held_out);
  if (out.size() < 4) return {};
  std::vector<std::size_t> found;
  const auto look_at = [&](const Minimum& minimum) {
    if (minimum.at.empty()) return;
    const auto [run, fall] = worst_run(residuals.unknowns(), minimum, out);
    if (fall > 0 && std::ranges::count(found, run) == 0) found.push_back(run);
  };
  look_at(linearised(residuals, best));
  if (rejected && residuals.linear_in_conditions()) look_at(homed_in(residuals, best.z, kRough));
  return found;
}

/// Of free slides alone: how many of their numbers are independent. Their points err alike beyond what they
/// tell, so that no law leaves chi^2 as it should be; of errors of an unknown size that many numbers say a
/// law is likelier where chi^2 falls by a share, by n ln of the ratio. 0 where there are driven runs.
double independent_points(const Residuals& residuals, Minimum best) {
  const Problem& problem = residuals.unknowns().problem();
  best = linearised(residuals, std::move(best));
  if (!problem.summary_runs.empty() || best.at.empty() || problem.has_driven_tracks()) return 0;
  const ExcessVariance excess =
      estimate_excess_variance(residuals, residuals.unknowns().values(best.z), best.at);
  constexpr double kOwn = 5;  ///< numbers of each slide that place, velocity and mu1 take
  double count = 0;
  for (std::size_t i = 0; i < excess.trajectories.size(); ++i)
    count += std::max(
        0.0, 2 * static_cast<double>(residuals.track(i).points()) / excess.trajectories[i].correlation_time -
                 kOwn);
  return count;
}

/// One thing for all slides, where a spin of each describes nearly anything about as well.
bool shared(const Explanation& found) {
  return found.name != kUnseenSpin || found.dof == 1;
}

/// Laws and spins brake nearly alike: of slides none is the cause alone that is not much likelier than
/// others. What they share comes first; spins of each count beside it where it leaves something to explain.
void weigh_causes_of_slides(std::vector<ExplainedProblem>& list) {
  const auto rank = [](const ExplainedProblem& e) {
    return std::tuple(e.found.explains, shared(e.found), e.found.p_after > kExplained, e.gain);
  };
  const auto first = std::ranges::max_element(list, {}, rank);
  if (first == list.end() || !first->found.explains) return;
  const double most = first->gain;
  const bool explained = first->found.p_after > kExplained;
  for (ExplainedProblem& other : list) {
    const bool near = other.gain > std::max(0.0, most - kPreferred);
    other.found.explains =
        other.found.refitted &&
        (shared(other.found) ? near : other.found.p_after > kExplained && (!explained || near));
    if (other.found.explains) other.gain = most;
  }
  std::rotate(list.begin(), first, first + 1);
}

}  // namespace

std::string sentence_of(const Explanation& e) {
  if (e.name == "bad_run") return "run '" + e.run + "', which contradicts the others";
  const auto found = std::ranges::find(candidates(), e.name, &Candidate::name);
  const char* what = found == candidates().end() ? "friction that differs from run to run" : found->what;
  return fmt::format("{} ({} {})", what, quoted(e.size, e.size_sd), e.unit);
}

std::vector<ExplainedProblem> explanations(const Residuals& residuals, const Minimum& best, bool rejected,
                                           int threads) {
  const Problem& problem = residuals.unknowns().problem();
  const std::size_t runs = problem.summary_runs.size();
  const ScoreTests tests(residuals, best, threads);
  if (tests.empty()) return {};
  struct Tested {
    Explanation found;
    std::function<Problem()> problem;
    const Candidate* candidate;
    Eigen::VectorXd values = {};
  };
  std::vector<Tested> list;
  for (const Candidate& candidate : candidates())
    if (auto found = tests.test(candidate))
      list.push_back(
          {std::move(*found), [&] { return with_free(problem, candidate.quantities); }, &candidate});
  for (const std::size_t run : suspects(residuals, best, rejected))
    if (auto found = tests.test_run(run))
      list.push_back({std::move(*found),
                      [&, run] {
                        Problem without = problem;
                        without.summary_runs[run].held_out = true;
                        return without;
                      },
                      nullptr});
  if (auto scatter = tests.test_scatter())  // it takes the minimum with it: found by a search of its own
    list.push_back({std::move(*scatter), nullptr, nullptr});

  const auto better = [&](const Tested& a, const Tested& b) {
    return gain(a.found, runs) > gain(b.found, runs);
  };
  std::stable_sort(list.begin(), list.end(), better);
  if (rejected) {
    constexpr double kWorthAFit = 0.2;  ///< of the best's gain
    constexpr std::size_t kMostFits = 6;
    const double most = list.empty() ? 0 : gain(list.front().found, runs);
    // A fit to tracks takes long: of what explains them a half shows to first order.
    const double excess = problem.has_driven_tracks() ? best.chi2 - residuals.degrees_of_freedom() : 0;
    const double least = std::max({9.0, kWorthAFit * most, 0.5 * excess});
    for (std::size_t i = 0; i < list.size(); ++i) {
      const bool bad_run = list[i].found.name == "bad_run";
      // Driven runs do not lead from one speed at which friction has fallen to another.
      const bool anyway = bad_run || (list[i].found.name == kStribeck && runs > 0);
      if (!list[i].problem) continue;
      if (anyway || (i < kMostFits && gain(list[i].found, runs) > least))
        list[i].values = tests.refit(list[i].problem(), list[i].candidate, bad_run, list[i].found);
    }
    if (const auto spinning =
            with_unseen_spin(problem, residuals.unknowns(), residuals.unknowns().values(best.z))) {
      Tested spin{{}, [spinning] { return *spinning; }, &candidates().back()};
      spin.found.name = kUnseenSpin;
      spin.found.unit = spin.candidate->unit;
      spin.found.dof = static_cast<int>(spinning->trajectory_runs.size());
      spin.values = tests.refit(*spinning, spin.candidate, false, spin.found);
      if (spin.found.refitted) list.push_back(std::move(spin));
    }
    std::stable_sort(list.begin(), list.end(), better);
  }
  const auto is_bad_run = [](const Tested& tested) { return tested.found.name == "bad_run"; };
  if (const auto worst = std::ranges::find_if(list, is_bad_run); worst != list.end())
    list.erase(std::remove_if(worst + 1, list.end(), is_bad_run), list.end());
  const double of_slides = independent_points(residuals, best);
  std::vector<ExplainedProblem> result;
  for (Tested& tested : list) {
    Explanation& found = tested.found;
    const double left = best.chi2 - found.chi2_fall;
    const double likelier =
        (of_slides > 0 && left > 0 ? of_slides * std::log(best.chi2 / left) : found.chi2_fall) -
        2 * found.dof;
    const bool by_likelihood = of_slides > 0 && likelier > kPreferred && shared(found);
    found.explains = rejected && found.refitted && gain(found, runs) > kPreferred &&
                     (found.p_after > kExplained || by_likelihood);
    result.push_back({found, found.refitted ? tested.problem() : Problem{}, tested.values, likelier});
  }
  if (of_slides > 0) weigh_causes_of_slides(result);
  return result;
}

}  // namespace tribotrack::fit::internal
