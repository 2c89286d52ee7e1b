#include "apps/bench/fit/coverage.h"

#include <atomic>
#include <cmath>
#include <mutex>

#include "fit/estimate.h"
#include "fit/tools/parallel.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

struct Group {
  Design design;
  NoiseLevel level;
  std::vector<FitParameter> parameters = {};
  std::vector<JudgedCampaign> campaigns = {};
};

/// P(X <= k) for X binomial.
double binomial_cdf(int k, int n, double p) {
  double sum = 0;
  for (int i = 0; i <= k; ++i)
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) + i * std::log(p) +
                    (n - i) * std::log1p(-p));
  return sum;
}

/// p in (0, 1) where a falling function of it crosses `level`.
template <class Function>
double where_it_falls_to(double level, const Function& f) {
  double low = 0, high = 1;
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2;
    (f(middle) > level ? low : high) = middle;
  }
  return (low + high) / 2;
}

std::vector<CoverageRow> rows_of(const Group& group) {
  std::vector<CoverageRow> rows;
  for (std::size_t i = 0; i < group.parameters.size(); ++i) {
    CoverageRow row;
    row.design = group.design;
    row.level = group.level;
    row.parameter = fit::to_string(group.parameters[i]);
    for (const JudgedCampaign& campaign : group.campaigns) {
      ++row.campaigns;
      if (campaign.parameters.empty()) continue;
      const JudgedInterval& interval = campaign.parameters[i];
      row.covered_of_all += interval.holds;
      if (!campaign.usable) continue;
      ++row.usable;
      row.weak += campaign.weak;
      row.open += interval.open;
      row.covered += interval.holds;
      row.score += interval.score;
    }
    if (row.usable > 0) row.score /= row.usable;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

Interval binomial_ci95(int hits, int trials) {
  return {
      hits > 0 ? where_it_falls_to(0.975, [&](double p) { return binomial_cdf(hits - 1, trials, p); }) : 0,
      hits < trials ? where_it_falls_to(0.025, [&](double p) { return binomial_cdf(hits, trials, p); }) : 1};
}

Interval CoverageRow::share_ci95() const {
  return binomial_ci95(covered, usable);
}

JudgedCampaign judge(const CoverageCampaign& campaign) {
  FitOptions options;
  options.next_experiment = false;
  JudgedCampaign judged;
  try {
    const FitResult result = estimate(campaign.problem, options);
    judged.usable = result.usable();
    judged.weak = result.identifiability.verdict == Verdict::weak;
    for (std::size_t i = 0; i < campaign.truth.size(); ++i)
      judged.parameters.push_back(judge_quoted(result.parameters[i], campaign.truth[i], campaign.bound[i]));
  } catch (const std::exception& failure) {
    judged.failure = failure.what();
  }
  return judged;
}

std::vector<CoverageRow> coverage(const CoverageOptions& options) {
  std::vector<Group> groups;
  for (const Design design : options.designs)
    for (const NoiseLevel level : options.levels) {
      groups.push_back({design, level});
      const int count = design == Design::trajectories ? options.of_trajectories : options.campaigns;
      groups.back().campaigns.resize(static_cast<std::size_t>(std::max(0, count)));
      groups.back().parameters = draw_campaign(design, level, options.seed, 0).problem.free;
    }
  std::vector<std::pair<Group*, int>> work;
  for (Group& group : groups)
    for (std::size_t k = 0; k < group.campaigns.size(); ++k) work.emplace_back(&group, static_cast<int>(k));
  int done = 0;
  std::mutex mutex;
  fit::internal::parallel_for(work.size(), options.threads, [&](std::size_t i) {
    const auto [group, k] = work[i];
    group->campaigns[static_cast<std::size_t>(k)] =
        judge(draw_campaign(group->design, group->level, options.seed, k));
    const std::lock_guard lock(mutex);
    if (options.progress) options.progress(++done, static_cast<int>(work.size()));
  });
  std::vector<CoverageRow> rows;
  for (const Group& group : groups)
    for (const CoverageRow& row : rows_of(group)) rows.push_back(row);
  return rows;
}

}  // namespace tribotrack::bench
