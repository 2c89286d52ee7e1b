#include "apps/bench/fit/coverage.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "fit/estimate.h"
#include "model/parallel.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

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

std::vector<JudgedParameter> judged_campaigns(const CoverageOptions& options) {
  struct Work {
    Design design;
    NoiseLevel level;
    int campaign;
    std::vector<JudgedParameter> judged = {};
  };
  std::vector<Work> work;
  std::size_t number = 0;
  for (const Design design : options.designs)
    for (const NoiseLevel level : options.levels)
      for (int k = 0; k < (design == Design::trajectories ? options.of_trajectories : options.campaigns); ++k)
        if (number++ % options.parts == options.part - 1) work.push_back({design, level, k});
  int done = 0;
  std::mutex mutex;
  parallel_for(work.size(), options.threads, [&](std::size_t i) {
    auto& [design, level, k, rows] = work[i];
    const CoverageCampaign campaign = draw_campaign(design, level, options.seed, k);
    const JudgedCampaign judged = judge(campaign);
    for (std::size_t p = 0; p < campaign.problem.free.size(); ++p) {
      rows.push_back({design, level, k, fit::to_string(campaign.problem.free[p])});
      rows.back().fitted = !judged.parameters.empty();
      rows.back().usable = judged.usable;
      rows.back().weak = judged.weak;
      if (rows.back().fitted) rows.back().interval = judged.parameters[p];
    }
    const std::lock_guard lock(mutex);
    if (options.progress) options.progress(++done, static_cast<int>(work.size()));
  });
  std::vector<JudgedParameter> judged;
  for (const Work& one : work) judged.insert(judged.end(), one.judged.begin(), one.judged.end());
  return judged;
}

std::vector<CoverageRow> coverage_of(const std::vector<JudgedParameter>& judged) {
  std::vector<CoverageRow> rows;
  for (const JudgedParameter& one : judged) {
    auto row = std::ranges::find_if(rows, [&](const CoverageRow& r) {
      return r.design == one.design && r.level == one.level && r.parameter == one.parameter;
    });
    if (row == rows.end()) row = rows.insert(rows.end(), {one.design, one.level, one.parameter});
    ++row->campaigns;
    row->covered_of_all += one.fitted && one.interval.holds;
    if (!one.usable) continue;
    ++row->usable;
    row->weak += one.weak;
    row->open += one.interval.open;
    row->covered += one.interval.holds;
    row->score += one.interval.score;
  }
  for (CoverageRow& row : rows)
    if (row.usable > 0) row.score /= row.usable;
  return rows;
}

}  // namespace tribotrack::bench
