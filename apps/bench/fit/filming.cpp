#include "apps/bench/fit/filming.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <mutex>
#include <numbers>
#include <optional>

#include "fit/estimate.h"
#include "fit/goal.h"
#include "model/parallel.h"

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

/// As `watch` fits: from the last fit on. Profiles and the whole search, which take longest, only where the
/// covariance says that the goal is reached.
FitResult fit_so_far(const std::optional<FitResult>& last, const Problem& problem,
                     const std::vector<Goal>& goals, bool next) {
  FitOptions options;
  options.next_experiment = next;
  options.profiles = false;
  FitResult result = last ? estimate_from(*last, problem, options) : estimate(problem, options);
  if (!all_reached(goals, result)) return result;
  options.profiles = true;
  return estimate(problem, options);
}

Filmed film_until_known(Choice choice, SimulatedLab lab, const FilmingOptions& options) {
  const std::vector<Goal> goals = {{FitParameter::mu1, options.goal, true}};
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  Filmed filmed;
  std::optional<FitResult> last;
  auto [phi, dtau] = of_paper(0);
  while (filmed.runs < options.most_runs) {
    problem.summary_runs.push_back(lab.film(phi, dtau));
    const FitResult& result = last.emplace(fit_so_far(last, problem, goals, choice == Choice::next_for_goal));
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

/// The same truth for every choice; drawn anew where the peer's integrator does not get through a run.
std::array<Filmed, std::size(kChoices)> film_by_every_choice(NoiseLevel level, int index,
                                                             const FilmingOptions& options) {
  for (;; index += options.campaigns) try {
      std::array<Filmed, std::size(kChoices)> filmed;
      for (std::size_t c = 0; c < std::size(kChoices); ++c)
        filmed[c] = film_until_known(kChoices[c], SimulatedLab(level, options.seed, index), options);
      return filmed;
    } catch (const PeerHangs&) {
    }
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
  struct Part {
    NoiseLevel level;
    int index;
    std::array<Filmed, std::size(kChoices)> filmed = {};
  };
  std::vector<Part> parts;
  for (const NoiseLevel level : options.levels)
    for (int k = 0; k < options.campaigns; ++k) parts.push_back({level, k});
  int done = 0;
  std::mutex mutex;
  parallel_for(parts.size(), options.threads, [&](std::size_t i) {
    parts[i].filmed = film_by_every_choice(parts[i].level, parts[i].index, options);
    const std::lock_guard lock(mutex);
    if (options.progress) options.progress(++done, static_cast<int>(parts.size()));
  });
  std::vector<FilmingRow> rows;
  for (const NoiseLevel level : options.levels)
    for (std::size_t c = 0; c < std::size(kChoices); ++c) {
      std::vector<Filmed> campaigns;
      for (const Part& part : parts)
        if (part.level == level) campaigns.push_back(part.filmed[c]);
      rows.push_back(row_of(kChoices[c], level, campaigns));
    }
  return rows;
}

}  // namespace tribotrack::bench
