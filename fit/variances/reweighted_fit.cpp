#include "fit/variances/reweighted_fit.h"

#include <algorithm>
#include <cmath>

#include "fit/tools/dense.h"
#include "fit/variances/excess_variance.h"
#include "fit/variances/robust.h"

namespace tribotrack::fit::internal {
namespace {

constexpr int kReweightings = 12;

/// The same evaluation under other weights, without simulating again: summary rows only differ by factors.
bool reweigh(Minimum& at, const Residuals& before, const Residuals& now) {
  const Problem& problem = now.unknowns().problem();
  if (!problem.trajectory_runs.empty() || at.jacobian.rows() == 0) return false;
  for (std::size_t i = 0; i < problem.summary_runs.size(); ++i) {
    const auto row = 2 * static_cast<Eigen::Index>(i);
    const double root = std::sqrt(now.run_weight(i) / before.run_weight(i));
    const Eigen::Matrix2d factor =
        root * Factor2(now.covariance(i)).whiten_columns(Factor2(before.covariance(i)).lower());
    at.residuals.segment<2>(row) = (factor * at.residuals.segment<2>(row)).eval();
    at.jacobian.middleRows(row, 2) = (factor * at.jacobian.middleRows(row, 2)).eval();
  }
  at.chi2 = at.residuals.squaredNorm();
  return true;
}

double largest_change(const Weights& a, const Weights& b) {
  double change = 0;
  for (std::size_t i = 0; i < a.runs.size(); ++i)
    change = std::max(change, std::abs(a.runs[i] - (b.runs.empty() ? 1 : b.runs[i])));
  return change;
}

bool unchanged(const ExcessVariance& was, const ExcessVariance& is) {
  bool same = std::abs(is.along - was.along) <= 1e-3 * was.along &&
              std::abs(is.across - was.across) <= 1e-3 * was.across;
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
  return scatter.runs() > 0 || std::any_of(scatter.trajectories.begin(), scatter.trajectories.end(),
                                           [](const auto& run) { return run.between_points > 0; });
}

CorrelatedEstimate reweighted_fit(Residuals& residuals, Minimum& best, const Reweighting& reweighting) {
  const Unknowns& unknowns = residuals.unknowns();
  const bool squares = reweighting.loss == Loss::squares;
  CorrelatedEstimate correlated;
  for (int round = 0; round < kReweightings; ++round) {
    const Residuals before = residuals;
    if (best.jacobian.rows() == 0) best = with_curvature(residuals, best).minimum;
    const Eigen::VectorXd values = unknowns.values(best.z);
    if (reweighting.correlated_errors) {
      correlated = estimate_correlated_errors(residuals, values);
      ExcessVariance scatter = residuals.excess_variance();
      scatter.correlated = correlated.variances;
      residuals.set_excess_variance(scatter);
    }
    if (reweighting.scatter)
      residuals.set_excess_variance(squares ? estimate_excess_variance(residuals, values, best.residuals)
                                            : robust_excess_variance(residuals, values, best.residuals));
    if (!squares) residuals.set_weights(robust_weights(residuals, values, best.residuals, reweighting.loss));
    const ExcessVariance &was = before.excess_variance(), &is = residuals.excess_variance();
    if (squares && !any(is) && is.correlated == CorrelatedVariances{} && was.correlated == is.correlated)
      return correlated;
    const double change = largest_change(residuals.weights(), before.weights());
    MinimiseOptions options;
    if (reweigh(best, before, residuals)) options.evaluated = &best;
    best = minimise(residuals, best.z, options);
    if (round > (reweighting.scatter ? 1 : 0) && change < 1e-3 && unchanged(was, is)) return correlated;
  }
  return correlated;
}

}  // namespace tribotrack::fit::internal
