#include "apps/bench/fit/filming.h"

#include <algorithm>
#include <mutex>
#include <numbers>

#include "fit/estimate.h"
#include "fit/goal.h"
#include "fit/tools/parallel.h"

namespace tribotrack::bench {

using namespace fit;
using std::numbers::pi;

namespace {

struct Filmed {
  int runs = 0;
  bool reached = false, holds = false;
};

std::pair<double, double> of_paper(int run) {
  const int k = run % 14;
  return k < 8 ? std::pair(k * pi / 4, pi / 3) : std::pair(0.0, (k - 7) * pi / 6);
}

/// Profiles, which take longest, only where the covariance says that the goal is reached.
FitResult fit_so_far(const Problem& problem, const std::vector<Goal>& goals, bool next) {
  FitOptions options;
  options.next_experiment = next;
  options.profiles = false;
  FitResult result = estimate(problem, options);
  if (!all_reached(goals, result)) return result;
  options.profiles = true;
  return estimate(problem, options);
}

Filmed film_until_known(Choice choice, SimulatedLab lab, const FilmingOptions& options) {
  const std::vector<Goal> goals = {{FitParameter::mu1, options.goal, true}};
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  Filmed filmed;
  auto [phi, dtau] = of_paper(0);
  while (filmed.runs < options.most_runs) {
    problem.summary_runs.push_back(lab.film(phi, dtau));
    const FitResult result = fit_so_far(problem, goals, choice == Choice::next_for_goal);
    ++filmed.runs;
    if (all_reached(goals, result)) {
      const Interval& interval = result.parameters.front().ci95;
      filmed.reached = true;
      filmed.holds = interval.low <= lab.mu1() && lab.mu1() <= interval.high;
      break;
    }
    std::tie(phi, dtau) = of_paper(filmed.runs);
    if (choice == Choice::next_for_goal)
      if (const NextExperiment* next = next_for(goals, result))
        std::tie(phi, dtau) = std::pair(next->phi, next->dtau);
  }
  return filmed;
}

FilmingRow row_of(Choice choice, NoiseLevel level, const std::vector<Filmed>& campaigns) {
  FilmingRow row{choice, level, static_cast<int>(campaigns.size())};
  std::vector<double> runs;
  for (const Filmed& filmed : campaigns) {
    row.reached += filmed.reached;
    row.holds += filmed.reached && filmed.holds;
    runs.push_back(filmed.runs);
  }
  std::ranges::sort(runs);
  const auto quartile = [&](double share) {
    return runs.empty() ? 0
                        : runs[static_cast<std::size_t>(share * static_cast<double>(runs.size() - 1) + 0.5)];
  };
  row.runs_low = quartile(0.25);
  row.runs_median = quartile(0.5);
  row.runs_high = quartile(0.75);
  return row;
}

}  // namespace

const char* to_string(Choice choice) {
  return choice == Choice::paper ? "the paper's design" : "as watch suggests";
}

FilmingOptions quick_filming_options() {
  FilmingOptions options;
  options.campaigns = 1;
  options.goal = 0.2;
  options.most_runs = 6;
  options.levels = {NoiseLevel::low};
  return options;
}

std::vector<FilmingRow> filming(const FilmingOptions& options) {
  struct Group {
    Choice choice;
    NoiseLevel level;
    std::vector<Filmed> campaigns;
  };
  std::vector<Group> groups;
  for (const NoiseLevel level : options.levels)
    for (const Choice choice : kChoices)
      groups.push_back(
          {choice, level, std::vector<Filmed>(static_cast<std::size_t>(std::max(0, options.campaigns)))});
  std::vector<std::pair<Group*, std::size_t>> work;
  for (Group& group : groups)
    for (std::size_t k = 0; k < group.campaigns.size(); ++k) work.emplace_back(&group, k);
  int done = 0;
  std::mutex mutex;
  fit::internal::parallel_for(work.size(), options.threads, [&](std::size_t i) {
    const auto [group, k] = work[i];
    // The same truth for both choices.
    group->campaigns[k] = film_until_known(
        group->choice, SimulatedLab(group->level, options.seed, static_cast<int>(k)), options);
    const std::lock_guard lock(mutex);
    if (options.progress) options.progress(++done, static_cast<int>(work.size()));
  });
  std::vector<FilmingRow> rows;
  for (const Group& group : groups) rows.push_back(row_of(group.choice, group.level, group.campaigns));
  return rows;
}

}  // namespace tribotrack::bench
