#include "fit/uncertainty/covariance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "fit/tools/dense.h"
#include "fit/tools/stage_progress.h"
#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"
#include "fit/variances/excess_variance.h"
#include "model/alpha_v.h"
#include "model/parallel.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kFlat = 1e-9;

struct Pseudo {
  Eigen::VectorXd singular_values;
  Eigen::MatrixXd directions;
  Eigen::Index rank;
  Eigen::MatrixXd inverse;  ///< of S'S
};

Pseudo pseudo_inverse(const Eigen::MatrixXd& sensitivity) {
  Pseudo result;
  const Eigen::Index n = sensitivity.cols();
  // The triangle of a QR decomposition has the same singular values and directions at a fraction of the cost.
  const SingularValues svd = singular_values(sensitivity.rows() > n ? triangle_of(sensitivity) : sensitivity);
  result.singular_values = Eigen::VectorXd::Zero(n);
  result.singular_values.head(svd.values.size()) = svd.values;
  result.directions = svd.directions;
  const double strongest = n > 0 ? result.singular_values(0) : 0;
  result.rank = (result.singular_values.array() > kFlat * strongest).count();
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(n);
  for (Eigen::Index k = 0; k < result.rank; ++k) squares(k) = std::pow(result.singular_values(k), -2);
  result.inverse = result.directions * squares.asDiagonal() * result.directions.transpose();
  return result;
}

}  // namespace

Uncertainty uncertainty(const Unknowns& unknowns, const Eigen::VectorXd& values, const Linearised& at) {
  const Eigen::VectorXd units = unknowns.natural_units(values), shared = units.head(unknowns.common());
  const Eigen::Index n = unknowns.reported(), conditions = unknowns.common() - n;
  const Linearised sensitivity = at.scaled(units);
  const Eigen::MatrixXd all = sensitivity.eliminated().triangle();

  Uncertainty result;
  result.units = units.head(n);
  result.column_norms = sensitivity.normal().diagonal().head(n).cwiseSqrt();
  Eigen::MatrixXd own = all.leftCols(n);
  if (conditions > 0) {
    // What the conditions can imitate is no information.
    const Eigen::MatrixXd q = orthonormal_basis(all.rightCols(conditions));
    own -= q * (q.transpose() * own).eval();
  }
  const Pseudo reported = pseudo_inverse(own);
  result.singular_values = reported.singular_values;
  result.directions = reported.directions;
  result.rank = reported.rank;
  result.covariance = result.units.asDiagonal() * reported.inverse * result.units.asDiagonal();
  result.shared = shared.asDiagonal() * pseudo_inverse(all).inverse * shared.asDiagonal();
  return result;
}

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kGone = 1e-9;           ///< of what all runs say: nothing else says anything of this unknown
constexpr double kUndetermined = 1e-10;  ///< of the strongest direction

/// The change of what all runs share, NaN where the others do not determine a direction that matters.
Eigen::VectorXd change(const Eigen::MatrixXd& all, const Eigen::MatrixXd& rows, const Eigen::VectorXd& r) {
  const Eigen::Index n = all.rows();
  const Eigen::MatrixXd others = all - rows.transpose() * rows;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < n; ++i)
    if (others(i, i) > kGone * all(i, i)) kept.push_back(i);
  Eigen::VectorXd result = Eigen::VectorXd::Constant(n, kUnknown);
  if (kept.empty()) return result;
  const Eigen::MatrixXd left = others(kept, kept);
  const auto inverse = internal::pseudo_inverse(left, unit_diagonal(left), kUndetermined);
  if (inverse.rank < left.rows()) return result;
  const Eigen::VectorXd step = inverse.inverse * (rows.transpose() * r)(kept);
  for (std::size_t k = 0; k < kept.size(); ++k) result(kept[k]) = step(static_cast<Eigen::Index>(k));
  return result;
}

}  // namespace

Eigen::MatrixXd influence_of_runs(const Residuals& residuals, const Minimum& best,
                                  const Uncertainty& uncertainty) {
  const Problem& problem = residuals.unknowns().problem();
  const auto summary = static_cast<Eigen::Index>(problem.summary_runs.size());
  const auto trajectories = static_cast<Eigen::Index>(problem.trajectory_runs.size());
  const Eigen::Index reported = residuals.unknowns().reported();
  Eigen::MatrixXd influence = Eigen::MatrixXd::Constant(summary + trajectories, reported, kUnknown);
  if (best.at.empty()) return influence;
  const Linearised left = best.at.eliminated();
  const Eigen::MatrixXd all = left.normal();
  const Eigen::VectorXd sd = uncertainty.covariance.diagonal().cwiseSqrt();
  for (Eigen::Index run = 0; run < summary + trajectories; ++run) {
    const std::size_t g = run < summary ? 0 : static_cast<std::size_t>(1 + run - summary);
    const RowGroup& group = left.groups[g];
    const Eigen::Index first = g == 0 ? 2 * run : 0, rows = g == 0 ? 2 : group.residuals.size();
    influence.row(run) =
        change(all, group.shared.middleRows(first, rows), group.residuals.segment(first, rows))
            .head(reported)
            .cwiseQuotient(sd)
            .transpose();
  }
  return influence;
}

Interval interval95(const Transform& transform, FitParameter parameter, double value, double sd, double t) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!std::isfinite(sd)) return {transform.positive() ? 0 : -kInfinity, kInfinity};
  const bool on_logarithm = transform.positive() && value > 0 && sd < 0.3 * value;
  if (on_logarithm) return {value * std::exp(-t * sd / value), value * std::exp(t * sd / value)};
  const double low = value - t * sd;
  const bool cut = parameter == FitParameter::mu1 || parameter == FitParameter::mu2;
  return {cut ? std::max(0.0, low) : low, cut ? std::max(0.0, value + t * sd) : value + t * sd};
}

std::map<FitParameter, EstimateUnder> estimates_under(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                                      const Eigen::MatrixXd& covariance) {
  const double t = two_sided_quantile(kConfidence, std::numeric_limits<double>::infinity());
  std::map<FitParameter, EstimateUnder> estimates;
  for (Eigen::Index i = 0; i < unknowns.reported(); ++i) {
    const double sd = std::sqrt(std::max(0.0, covariance(i, i)));
    const FitParameter parameter = unknowns.parameter(i);
    estimates[parameter] = {values(i), sd, interval95(unknowns.transform(i), parameter, values(i), sd, t)};
  }
  return estimates;
}

namespace {

/// Whitened errors as the fit's own covariance has them, `noise` times as large those of the data, less the
/// residuals at the minimum: what makes of these the residuals of data drawn there.
std::vector<Eigen::VectorXd> drawn(const Residuals& residuals, const Linearised& at, double noise,
                                   std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::vector<Eigen::VectorXd> errors;
  for (const RowGroup& group : at.groups)
    for (double& number : errors.emplace_back(group.residuals.size())) number = normal(random);
  for (std::size_t g = 0; g < errors.size(); ++g) {
    errors[g].head(residuals.layout().groups[g].data) *= noise;
    errors[g] -= at.groups[g].residuals;
  }
  return errors;
}

/// The point below which `share` of the sorted values lie.
double quantile(const std::vector<double>& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto k = static_cast<std::size_t>(place);
  if (k + 1 >= sorted.size()) return sorted.back();
  return sorted[k] + (place - static_cast<double>(k)) * (sorted[k + 1] - sorted[k]);
}

}  // namespace

Bootstrap bootstrap(const Residuals& residuals, const Minimum& best, bool scatter_estimated,
                    const FitOptions& options) {
  const Unknowns& unknowns = residuals.unknowns();
  const double dof = std::max(1.0, residuals.degrees_of_freedom());
  Residuals plain = residuals;
  plain.set_weights({});
  plain.set_tolerance(residuals.tolerance_for(0.03, 1e-5));
  const Eigen::VectorXd centre = unknowns.values(best.z);
  const std::optional<Linearised> at = plain.at(centre, false);
  if (!at) return {};
  std::vector<Eigen::VectorXd> estimates(static_cast<std::size_t>(options.bootstrap));
  Stage stage(options, "bootstrap", estimates.size());
  parallel_for(estimates.size(), options.threads, [&](std::size_t k) {
    std::seed_seq seed{options.bootstrap_seed, static_cast<unsigned>(k)};
    std::mt19937_64 random(seed);
    const double noise =
        scatter_estimated ? std::sqrt(dof / std::chi_squared_distribution<double>(dof)(random)) : 1;
    Residuals refit = plain;
    refit.set_shift(drawn(plain, *at, noise, random));
    Minimum minimum = minimise(refit, best.z, {.decrement = 1e-4});
    if (options.loss != Loss::squares && std::isfinite(minimum.chi2))
      reweighted_fit(refit, minimum, {.loss = options.loss});
    if (minimum.converged) estimates[k] = unknowns.values(minimum.z);
    stage.done();
  });
  Bootstrap result;
  std::erase_if(estimates, [](const Eigen::VectorXd& values) { return values.size() == 0; });
  result.converged = static_cast<int>(estimates.size());
  for (Eigen::Index i = 0; i < unknowns.reported(); ++i) {
    std::vector<double> sorted;
    for (const Eigen::VectorXd& values : estimates)
      sorted.push_back(unknowns.parameter(i) == FitParameter::lag
                           ? centre(i) + model::wrap_angle(values(i) - centre(i))
                           : values(i));
    std::sort(sorted.begin(), sorted.end());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    result.ci95.push_back(sorted.size() < 20 ? Interval{nan, nan}
                                             : Interval{quantile(sorted, 0.025), quantile(sorted, 0.975)});
  }
  return result;
}

}  // namespace tribotrack::fit::internal
