#include "fit/uncertainty/influence.h"

#include <cmath>
#include <limits>
#include <vector>

#include "fit/tools/dense.h"

namespace tribotrack::fit::internal {
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

}  // namespace tribotrack::fit::internal
