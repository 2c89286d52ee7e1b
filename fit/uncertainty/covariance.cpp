#include "fit/uncertainty/covariance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "fit/tools/dense.h"

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

Uncertainty uncertainty(const Unknowns& unknowns, const Eigen::VectorXd& values,
                        const Eigen::MatrixXd& jacobian) {
  const Eigen::VectorXd units = unknowns.natural_units(values);
  const Eigen::MatrixXd sensitivity = jacobian * units.asDiagonal();
  const Eigen::Index n = unknowns.reported(), nuisances = unknowns.size() - n;

  Uncertainty result;
  result.units = units.head(n);
  result.column_norms = sensitivity.leftCols(n).colwise().norm();
  Eigen::MatrixXd own = sensitivity.leftCols(n);
  if (nuisances > 0) {
    // What the nuisances can imitate is no information.
    const Eigen::MatrixXd q = orthonormal_basis(sensitivity.rightCols(nuisances));
    own -= q * (q.transpose() * own).eval();
  }
  const Pseudo reported = pseudo_inverse(own);
  result.singular_values = reported.singular_values;
  result.directions = reported.directions;
  result.rank = reported.rank;
  result.covariance = result.units.asDiagonal() * reported.inverse * result.units.asDiagonal();
  result.full_covariance = units.asDiagonal() * pseudo_inverse(sensitivity).inverse * units.asDiagonal();
  return result;
}

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kGone = 1e-9;           ///< of what all runs say: nothing else says anything of this unknown
constexpr double kUndetermined = 1e-10;  ///< of the strongest direction

/// The change of all unknowns, NaN where the others do not determine a direction that matters.
Eigen::VectorXd change(const Eigen::MatrixXd& all, const Eigen::MatrixXd& rows, const Eigen::VectorXd& r) {
  const Eigen::Index n = all.rows();
  const Eigen::MatrixXd others = all - rows.transpose() * rows;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < n; ++i)
    if (others(i, i) > kGone * all(i, i)) kept.push_back(i);
  Eigen::VectorXd result = Eigen::VectorXd::Constant(n, kUnknown);
  if (kept.empty()) return result;
  const Eigen::VectorXd scale = others(kept, kept).diagonal().cwiseSqrt().cwiseInverse();
  const EigenSystem eigen = eigen_symmetric(scale.asDiagonal() * others(kept, kept) * scale.asDiagonal());
  if (!(eigen.values(0) > kUndetermined * eigen.values.maxCoeff())) return result;
  const Eigen::VectorXd gradient = (rows.transpose() * r)(kept);
  const Eigen::VectorXd step =
      scale.asDiagonal() * (eigen.vectors * (eigen.values.cwiseInverse().asDiagonal() *
                                             (eigen.vectors.transpose() * (scale.asDiagonal() * gradient))));
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
  if (best.jacobian.rows() != best.residuals.size()) return influence;
  const Eigen::MatrixXd all = best.jacobian.transpose() * best.jacobian;
  const Eigen::VectorXd sd = uncertainty.covariance.diagonal().cwiseSqrt();
  for (Eigen::Index run = 0; run < summary + trajectories; ++run) {
    const auto track = static_cast<std::size_t>(run - summary);
    const Eigen::Index first = run < summary ? 2 * run : residuals.trajectory_row(track);
    const Eigen::Index rows = run < summary ? 2 : 2 * static_cast<Eigen::Index>(residuals.point_count(track));
    influence.row(run) =
        change(all, best.jacobian.middleRows(first, rows), best.residuals.segment(first, rows))
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
  return {cut ? std::max(0.0, low) : low, value + t * sd};
}

}  // namespace tribotrack::fit::internal
