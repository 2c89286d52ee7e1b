#include "fit/variances/reweighted_fit.h"

#include <algorithm>
#include <cmath>

#include "fit/tools/statistics.h"
#include "fit/variances/excess_variance.h"
#include "fit/variances/robust.h"

namespace tribotrack::fit::internal {
namespace {

constexpr int kReweightings = 12;

double largest_change(const Residuals& now, const Residuals& before) {
  double change = 0;
  for (std::size_t i = 0; i < now.weights().size(); ++i)
    change = std::max(change, std::abs(now.weight(i) - before.weight(i)));
  return change;
}

bool unchanged(const ExcessVariance& was, const ExcessVariance& is) {
  bool same = std::abs(is.runs - was.runs) <= 1e-3 * was.runs;
  for (std::size_t i = 0; i < is.trajectories.size(); ++i)
    same = same && std::abs(is.trajectories[i].between_points - was.trajectories[i].between_points) <=
                       1e-2 * was.trajectories[i].between_points;
  for (std::size_t part = 0; part < kErrorParts; ++part)
    same = same && std::abs(is.correlated[part] - was.correlated[part]) <=
                       3e-2 * was.correlated[part];  // known to 20 %
  return same;
}

}  // namespace

bool any(const ExcessVariance& scatter) {
  return scatter.runs > 0 || std::any_of(scatter.trajectories.begin(), scatter.trajectories.end(),
                                         [](const auto& run) { return run.between_points > 0; });
}

CorrelatedEstimate reweighted_fit(Residuals& residuals, Minimum& best, const Reweighting& reweighting) {
  const Unknowns& unknowns = residuals.unknowns();
  const bool squares = reweighting.loss == Loss::squares;
  CorrelatedEstimate correlated;
  for (int round = 0; round < kReweightings; ++round) {
    const Residuals before = residuals;
    best = linearised(residuals, std::move(best));
    const Eigen::VectorXd values = unknowns.values(best.z);
    if (reweighting.correlated_errors) {
      correlated = estimate_correlated_errors(residuals, values);
      ExcessVariance scatter = residuals.excess_variance();
      scatter.correlated = correlated.variances;
      residuals.set_excess_variance(scatter);
    }
    if (reweighting.scatter)
      residuals.set_excess_variance(estimate_excess_variance(residuals, values, best.at, reweighting.loss));
    if (!squares) residuals.set_weights(robust_weights(residuals, best.at));
    const ExcessVariance &was = before.excess_variance(), &is = residuals.excess_variance();
    if (squares && !any(is) && is.correlated == CorrelatedVariances{} && was.correlated == is.correlated)
      return correlated;
    const double change = largest_change(residuals, before);
    best = minimise(residuals, best.z);
    if (round > (reweighting.scatter ? 1 : 0) && change < 1e-3 && unchanged(was, is)) return correlated;
  }
  return correlated;
}

namespace {

constexpr double kHuber = 2;

double distance(const Residuals& residuals, const Linearised& at, std::size_t run) {
  return at.groups.front().residuals.segment<2>(2 * static_cast<Eigen::Index>(run)).norm() /
         std::sqrt(residuals.weight(run));
}

}  // namespace

double robust_weight(double s) {
  return s <= kHuber ? 1 : kHuber / s;
}

std::vector<double> robust_weights(const Residuals& residuals, const Linearised& at) {
  std::vector<double> weights;
  for (std::size_t i = 0; i < residuals.unknowns().problem().summary_runs.size(); ++i)
    weights.push_back(robust_weight(distance(residuals, at, i)));
  return weights;
}

double robust_covariance_factor(const Residuals& residuals, const Linearised& at) {
  const auto runs = residuals.unknowns().problem().summary_runs.size();
  const double n = 2 * static_cast<double>(runs), p = static_cast<double>(residuals.unknowns().size());
  double psi_square = 0, mean = 0, square = 0;
  for (std::size_t i = 0; i < runs; ++i) {
    const double s = distance(residuals, at, i), psi = s * robust_weight(s);
    const double k = s < kHuber ? 1 : 0.5 * kHuber / s;  // half the trace of d psi/d r in the plane
    psi_square += psi * psi;
    mean += k / static_cast<double>(runs);
    square += k * k / static_cast<double>(runs);
  }
  const double correction = 1 + p / n * std::max(0.0, square - mean * mean) / (mean * mean);
  return correction * correction * (psi_square / std::max(1.0, n - p)) / (mean * mean);
}

const char* robust_meaning(Loss loss) {
  return loss == Loss::squares
             ? ""
             : " Robust loss (Huber): runs beyond 2 sigma count less and the intervals are an M-estimate's "
               "(Huber's formula), from the spread of the residuals; they trust that at most about one run "
               "in "
               "five is bad, and a profile likelihood has no meaning with it.";
}

}  // namespace tribotrack::fit::internal
