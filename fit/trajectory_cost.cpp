// Every tracked point against the model's dense trajectory. The start point is linear: it is projected out,
// so that it costs no unknown and is counted exactly.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

#include "fit/internal/residuals.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kFinestSigma = 1e-9;  ///< m; no camera sees less

}  // namespace

PointModel Residuals::modelled_points(const Eigen::VectorXd& values, std::size_t index,
                                      bool derivatives) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const AppliedScenario applied = run.free_slide ? unknowns_->apply_free_slide(values, index, derivatives)
                                                 : unknowns_->apply_trajectory(values, index, derivatives);
  std::vector<double> times;
  for (std::size_t i = first_point_[index]; i < run.track.time.size(); ++i)
    times.push_back(run.track.time[i] - run.track.time[first_point_[index]]);
  const bool camera_frame = !run.free_slide && !run.track.platform_frame;
  return model_points(*unknowns_, applied, times, camera_frame, tolerance_, derivatives);
}

void Residuals::trajectory(const Eigen::VectorXd& values, std::size_t index,
                           Eigen::Ref<Eigen::VectorXd> residuals, Eigen::MatrixXd* jacobian,
                           Eigen::Index row) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const std::size_t first = first_point_[index], n = point_count(index);
  const auto& scatter = scatter_.trajectories[index];
  PointModel modelled = modelled_points(values, index, jacobian != nullptr);
  const Eigen::Matrix2Xd& positions = modelled.positions;
  Eigen::MatrixXd& by_unknowns = modelled.jacobian;

  // Whitened residuals, their Jacobian, and the columns of the start point (W: residual = .. - W x0).
  const double added = scatter.between_points * scatter.between_points + kFinestSigma * kFinestSigma;
  const double uncorrelated = 1 / std::sqrt(scatter.correlation_time);
  Eigen::MatrixX2d start(2 * static_cast<Eigen::Index>(n), 2);
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = 2 * static_cast<Eigen::Index>(i);
    const Eigen::LLT<Eigen::Matrix2d> factor(
        Eigen::Matrix2d(run.track.covariance[first + i] + added * Eigen::Matrix2d::Identity()));
    const Eigen::Vector2d difference =
        run.track.position[first + i] - positions.col(static_cast<Eigen::Index>(i));
    const double weight = uncorrelated * std::sqrt(point_weight(index, i));
    residuals.segment<2>(k) = weight * factor.matrixL().solve(difference);
    start.middleRows<2>(k) = weight * factor.matrixL().solve(Eigen::Matrix2d::Identity()).eval();
    if (jacobian)
      by_unknowns.middleRows(k, 2) = -weight * factor.matrixL().solve(by_unknowns.middleRows(k, 2)).eval();
  }
  const Eigen::HouseholderQR<Eigen::MatrixX2d> qr(start);
  const Eigen::MatrixX2d q = qr.householderQ() * Eigen::MatrixX2d::Identity(start.rows(), 2);
  residuals -= q * (q.transpose() * residuals).eval();
  if (jacobian)
    jacobian->middleRows(row, by_unknowns.rows()) = by_unknowns - q * (q.transpose() * by_unknowns);
}

PointResiduals Residuals::points(const Eigen::VectorXd& values, std::size_t index) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const std::size_t first = first_point_[index], n = point_count(index);
  const double between = scatter_.trajectories[index].between_points;
  const double added = between * between + kFinestSigma * kFinestSigma;
  const Eigen::Matrix2Xd positions = modelled_points(values, index, false).positions;
  PointResiduals result;
  Eigen::Matrix2d weights = Eigen::Matrix2d::Zero();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    result.row.push_back(first + i);
    result.residual.push_back(run.track.position[first + i] - positions.col(static_cast<Eigen::Index>(i)));
    const Eigen::Matrix2d weight =
        point_weight(index, i) *
        (run.track.covariance[first + i] + added * Eigen::Matrix2d::Identity()).inverse();
    weights += weight;
    sum += weight * result.residual.back();
  }
  result.start_point = weights.ldlt().solve(sum);
  for (auto& residual : result.residual) residual -= result.start_point;
  return result;
}

}  // namespace tribotrack::fit::internal
