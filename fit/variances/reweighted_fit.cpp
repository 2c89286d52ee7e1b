#include "fit/variances/reweighted_fit.h"

#include <algorithm>
#include <cmath>

#include "fit/tools/dense.h"
#include "fit/tools/statistics.h"
#include "fit/variances/excess_variance.h"
#include "fit/variances/robust.h"

namespace tribotrack::fit::internal {
namespace {

constexpr int kReweightings = 12;

/// The same evaluation under other weights, without simulating again: summary rows only differ by factors.
bool reweigh(Minimum& at, const Residuals& before, const Residuals& now) {
  const Problem& problem = now.unknowns().problem();
  if (!problem.trajectory_runs.empty() || at.at.empty()) return false;
  RowGroup& rows = at.at.groups.front();
  for (std::size_t i = 0; i < problem.summary_runs.size(); ++i) {
    const auto row = 2 * static_cast<Eigen::Index>(i);
    const double root = std::sqrt(now.weights().of(i) / before.weights().of(i));
    const Eigen::Matrix2d factor =
        root * Factor2(now.covariance(i)).whiten_columns(Factor2(before.covariance(i)).lower());
    rows.residuals.segment<2>(row) = (factor * rows.residuals.segment<2>(row)).eval();
    rows.shared.middleRows(row, 2) = (factor * rows.shared.middleRows(row, 2)).eval();
  }
  at.chi2 = at.at.chi2();
  return true;
}

double largest_change(const Weights& a, const Weights& b) {
  double change = 0;
  for (std::size_t i = 0; i < a.runs.size(); ++i)
    change = std::max(change, std::abs(a.runs[i] - (b.runs.empty() ? 1 : b.runs[i])));
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
    if (!squares) residuals.set_weights(robust_weights(residuals, values, best.at, reweighting.loss));
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

namespace {

constexpr double kHuber = 2, kCauchy = 3;

double distance(const Residuals& residuals, const Linearised& at, std::size_t run) {
  return at.groups.front().residuals.segment<2>(2 * static_cast<Eigen::Index>(run)).norm() /
         std::sqrt(residuals.weights().of(run));
}

/// Half the trace of d psi/d r in the plane.
double slope(double s, Loss loss) {
  if (loss == Loss::huber) return s < kHuber ? 1 : 0.5 * kHuber / s;
  const double q = s * s / (kCauchy * kCauchy);
  return 0.5 * ((1 - q) / ((1 + q) * (1 + q)) + 1 / (1 + q));
}

}  // namespace

double robust_weight(double s, Loss loss) {
  switch (loss) {
    case Loss::squares:
      return 1;
    case Loss::huber:
      return s <= kHuber ? 1 : kHuber / s;
    case Loss::cauchy:
      return 1 / (1 + s * s / (kCauchy * kCauchy));
  }
  return 1;
}

Weights robust_weights(const Residuals& residuals, const Eigen::VectorXd& values, const Linearised& at,
                       Loss loss) {
  const Problem& problem = residuals.unknowns().problem();
  Weights weights;
  for (std::size_t i = 0; i < problem.summary_runs.size(); ++i) {
    const double s = distance(residuals, at, i);
    weights.runs.push_back(robust_weight(s, loss));
  }
  const Eigen::VectorXd common = residuals.common_error(values);
  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i) {
    const PointResiduals points = residuals.points(values, i, common);
    const double scatter = residuals.excess_variance().trajectories[i].between_points;
    std::vector<double>& here = weights.points.emplace_back();
    for (std::size_t k = 0; k < points.row.size(); ++k) {
      const Eigen::Matrix2d covariance =
          problem.trajectory_runs[i].track.covariance[points.row[k]] +
          (scatter * scatter + kFinestSigma * kFinestSigma) * Eigen::Matrix2d::Identity();
      here.push_back(robust_weight(
          std::sqrt(points.residual[k].dot(Factor2(covariance).solved(points.residual[k]))), loss));
    }
  }
  return weights;
}

double robust_covariance_factor(const Residuals& residuals, const Linearised& at, Loss loss) {
  if (loss == Loss::squares) return 1;
  const auto runs = residuals.unknowns().problem().summary_runs.size();
  if (runs == 0) return 1;
  const double n = 2 * static_cast<double>(runs), p = static_cast<double>(residuals.unknowns().size());
  double psi_square = 0, mean = 0, square = 0;
  for (std::size_t i = 0; i < runs; ++i) {
    const double s = distance(residuals, at, i), psi = s * robust_weight(s, loss), k = slope(s, loss);
    psi_square += psi * psi;
    mean += k / static_cast<double>(runs);
    square += k * k / static_cast<double>(runs);
  }
  const double correction = 1 + p / n * std::max(0.0, square - mean * mean) / (mean * mean);
  return correction * correction * (psi_square / std::max(1.0, n - p)) / (mean * mean);
}

const char* robust_meaning(Loss loss) {
  switch (loss) {
    case Loss::squares:
      return "";
    case Loss::huber:
      return " Robust loss (Huber): runs beyond 2 sigma count less and the intervals are an M-estimate's "
             "(Huber's formula), from the spread of the residuals; they trust that at most about one run in "
             "five is bad, and a profile likelihood has no meaning with it.";
    case Loss::cauchy:
      return " Robust loss (Cauchy): runs beyond 3 sigma are all but forgotten and the intervals are an "
             "M-estimate's (Huber's formula), from the spread of the residuals; they trust that at most "
             "about "
             "one run in five is bad, and a profile likelihood has no meaning with it.";
  }
  return "";
}

}  // namespace tribotrack::fit::internal
