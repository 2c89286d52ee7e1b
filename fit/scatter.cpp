#include "fit/internal/scatter.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fit/internal/statistics.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kAsks = 1e-3;

double chi2_with(const std::vector<Eigen::Vector2d>& residuals,
                 const std::vector<Eigen::Matrix2d>& covariances, double added) {
  double sum = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const Eigen::Matrix2d total = covariances[i] + added * added * Eigen::Matrix2d::Identity();
    sum += residuals[i].dot(total.inverse() * residuals[i]);
  }
  return sum;
}

/// s with chi^2(s) = expected; 0 where chi^2(0) is no surprise.
double scatter_for(const std::vector<Eigen::Vector2d>& residuals,
                   const std::vector<Eigen::Matrix2d>& covariances, double expected, bool already) {
  if (!(expected > 0)) return 0;
  const double now = chi2_with(residuals, covariances, 0);
  if (already ? now <= expected : chi2_survival(now, expected) >= kAsks) return 0;
  double high = 0;
  for (const auto& r : residuals) high = std::max(high, r.norm());
  double low = 0;
  while (chi2_with(residuals, covariances, high) > expected) high *= 2;
  for (int i = 0; i < 80; ++i) {
    const double middle = 0.5 * (low + high);
    (chi2_with(residuals, covariances, middle) > expected ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

Scatter estimate_scatter(const Residuals& residuals, const Eigen::VectorXd& values,
                         const Eigen::VectorXd& whitened) {
  const auto& problem = residuals.unknowns().problem();
  Scatter result = residuals.scatter();
  const double data = 2.0 * static_cast<double>(problem.summary_runs.size());
  double points = 0;
  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i)
    points += 2.0 * static_cast<double>(residuals.point_count(i)) / result.trajectories[i].correlation_time;

  std::vector<Eigen::Vector2d> differences;
  std::vector<Eigen::Matrix2d> covariances;
  for (std::size_t i = 0; i < problem.summary_runs.size(); ++i) {
    differences.push_back(residuals.difference(whitened, i));
    covariances.push_back(problem.summary_runs[i].measured.covariance);
  }
  // The unknowns take their share of the freedom from runs and points alike.
  const double unknowns = static_cast<double>(residuals.unknowns().size());
  const double share = std::max(0.0, 1 - unknowns / (data + points));
  result.between_runs = scatter_for(differences, covariances, data * share, result.between_runs > 0);

  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i) {
    const PointResiduals run = residuals.points(values, i);
    auto& scatter = result.trajectories[i];
    covariances.clear();
    std::vector<double> x, y;
    for (std::size_t k = 0; k < run.row.size(); ++k) {
      covariances.push_back(problem.trajectory_runs[i].track.covariance[run.row[k]]);
      x.push_back(run.residual[k].x());
      y.push_back(run.residual[k].y());
    }
    // A fitted column takes as much of correlated noise as of that many independent points.
    const double along = problem.trajectory_runs[i].free_slide ? 3 : 1,
                 across = problem.trajectory_runs[i].free_slide ? 2 : 1;
    const double rows = 2.0 * static_cast<double>(run.row.size());
    const double expected = std::max(0.4 * rows, rows - (along + across) * scatter.correlation_time);
    scatter.between_points = scatter_for(run.residual, covariances, expected, scatter.between_points > 0);
    scatter.correlation_time = 1;
    if (scatter.between_points > 0) {
      double x_square = 0, y_square = 0;
      for (std::size_t k = 0; k < x.size(); ++k) {
        x_square += x[k] * x[k];
        y_square += y[k] * y[k];
      }
      const double both =
          (x_square * residual_correlation_time(x, along) + y_square * residual_correlation_time(y, along)) /
          (x_square + y_square);
      scatter.correlation_time = std::min(static_cast<double>(run.row.size()) / 4, both);
    }
  }
  return result;
}

}  // namespace tribotrack::fit::internal
