#include "apps/bench/coverage.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>

#include "fit/estimate.h"
#include "model/parallel.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

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

bool is_open(const std::vector<Interval>& pieces, bool turns) {
  double width = 0;
  for (const Interval& piece : pieces) width += piece.high - piece.low;
  return !std::isfinite(width) || (turns && width >= kTurn * (1 - 1e-9));
}

/// One campaign's contribution to its rows, which are one for each parameter.
std::vector<CoverageRow> judge(Design design, NoiseLevel level, const CoverageCampaign& campaign) {
  std::vector<CoverageRow> rows;
  for (const FitParameter parameter : campaign.problem.free)
    rows.push_back({design, level, fit::to_string(parameter), 1});
  FitOptions options;
  options.next_experiment = false;
  FitResult result;
  try {
    result = estimate(campaign.problem, options);
  } catch (const std::exception&) {
    return rows;  // not usable
  }
  if (!result.usable()) return rows;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ParameterEstimate& p = result.parameters[i];
    const bool turns = p.parameter == FitParameter::lag;
    const auto pieces = quoted_pieces(p);
    rows[i].usable = 1;
    rows[i].weak = result.identifiability.verdict == Verdict::weak;
    rows[i].open = is_open(pieces, turns);
    rows[i].covered = holds(pieces, campaign.truth[i], turns);
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

std::vector<Interval> quoted_pieces(const ParameterEstimate& parameter) {
  if (parameter.ci95_pieces.size() > 1) return {parameter.ci95_pieces.begin(), parameter.ci95_pieces.end()};
  return {parameter.ci95};
}

bool holds(const std::vector<Interval>& pieces, double value, bool turns) {
  return std::ranges::any_of(pieces, [&](const Interval& piece) {
    const double from = piece.low;
    const double near =
        turns && std::isfinite(from) ? value + kTurn * std::ceil((from - value) / kTurn) : value;
    return from <= near && near <= piece.high;
  });
}

std::vector<CoverageRow> coverage(const CoverageOptions& options) {
  struct Work {
    Design design;
    NoiseLevel level;
    int campaign;
    std::vector<CoverageRow> judged = {};
  };
  std::vector<Work> work;
  for (const Design design : kDesigns)
    for (const NoiseLevel level : kNoiseLevels)
      for (int k = 0; k < options.campaigns; ++k) work.push_back({design, level, k});
  int done = 0;
  std::mutex mutex;
  parallel_for(work.size(), options.threads, [&](std::size_t i) {
    auto& [design, level, k, judged] = work[i];
    judged = judge(design, level, draw_campaign(design, level, options.seed, k));
    const std::lock_guard lock(mutex);
    if (options.progress) options.progress(++done, static_cast<int>(work.size()));
  });
  std::vector<CoverageRow> rows;
  for (const Work& one : work)
    for (const CoverageRow& more : one.judged) {
      auto row = std::ranges::find_if(rows, [&](const CoverageRow& r) {
        return r.design == more.design && r.level == more.level && r.parameter == more.parameter;
      });
      if (row == rows.end()) row = rows.insert(rows.end(), {more.design, more.level, more.parameter});
      row->campaigns += more.campaigns;
      row->usable += more.usable;
      row->weak += more.weak;
      row->open += more.open;
      row->covered += more.covered;
    }
  return rows;
}

}  // namespace tribotrack::bench
