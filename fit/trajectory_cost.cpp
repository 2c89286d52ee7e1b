// Every tracked point against the model's dense trajectory. The start point is linear: it is projected out,
// so that it costs no unknown and is counted exactly.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "fit/internal/parallel.h"
#include "fit/internal/residuals.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kFinestSigma = 1e-9;  ///< m; no camera sees less

}  // namespace

std::vector<double> Residuals::times(std::size_t index) const {
  const auto& recorded = problem_->trajectory_runs[index].track.time;
  std::vector<double> result(recorded.begin() + static_cast<std::ptrdiff_t>(first_point_[index]),
                             recorded.end());
  const double first = result.front();
  for (double& time : result) time -= first;
  return result;
}

PointModel Residuals::modelled_points(const Eigen::VectorXd& values, std::size_t index,
                                      bool derivatives) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const AppliedScenario applied = run.free_slide ? unknowns_->apply_free_slide(values, index, derivatives)
                                                 : unknowns_->apply_trajectory(values, index, derivatives);
  const bool camera_frame = !run.free_slide && !run.track.platform_frame;
  return model_points(*unknowns_, applied, times(index), camera_frame, tolerance_, derivatives);
}

SlowShapes Residuals::shapes(std::size_t index, const std::array<bool, kSlowParts>& wanted) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  if (run.free_slide) return {};
  const double w = run.scenario.drive.amplitude > 0 ? run.scenario.drive.angular_frequency : 0;
  return slow_shapes(times(index), w, slow_reference_time_, wanted);
}

Eigen::MatrixX2d Residuals::white(std::size_t index) const {
  const auto& covariance = problem_->trajectory_runs[index].track.covariance;
  const auto& scatter = scatter_.trajectories[index];
  const double added = scatter.between_points * scatter.between_points + kFinestSigma * kFinestSigma;
  const double uncorrelated = 1 / std::sqrt(scatter.correlation_time);
  const std::size_t n = point_count(index);
  Eigen::MatrixX2d white(2 * static_cast<Eigen::Index>(n), 2);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::LLT<Eigen::Matrix2d> factor(
        Eigen::Matrix2d(covariance[first_point_[index] + i] + added * Eigen::Matrix2d::Identity()));
    white.middleRows<2>(2 * static_cast<Eigen::Index>(i)) =
        uncorrelated * std::sqrt(point_weight(index, i)) *
        factor.matrixL().solve(Eigen::Matrix2d::Identity()).eval();
  }
  return white;
}

void Residuals::prepare_slow() {
  std::array<bool, kSlowParts> wanted{};
  for (std::size_t part = 0; part < kSlowParts; ++part) wanted[part] = scatter_.slow[part] > 0;
  const bool any = std::find(wanted.begin(), wanted.end(), true) != wanted.end();
  parallel_for(slow_.size(), threads_, [&](std::size_t run) {
    const SlowShapes own = any ? shapes(run, wanted) : SlowShapes{};
    slow_[run] = own.count() > 0 ? SlowWhitening(own, white(run), scatter_.slow) : SlowWhitening{};
  });
}

void Residuals::trajectory(const Eigen::VectorXd& values, std::size_t index,
                           Eigen::Ref<Eigen::VectorXd> residuals, Eigen::MatrixXd* jacobian,
                           Eigen::Index row) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const std::size_t first = first_point_[index], n = point_count(index);
  PointModel modelled = modelled_points(values, index, jacobian != nullptr);
  const Eigen::Matrix2Xd& positions = modelled.positions;
  Eigen::MatrixXd& by_unknowns = modelled.jacobian;

  // Whitened residuals, their Jacobian, and the columns of the start point (residual = .. - white x0).
  const Eigen::MatrixX2d start = white(index);
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Matrix2d factor = start.middleRows<2>(k);
    residuals.segment<2>(k) =
        factor * (run.track.position[first + i] - positions.col(static_cast<Eigen::Index>(i)));
    if (jacobian) by_unknowns.middleRows(k, 2) = -factor * by_unknowns.middleRows(k, 2).eval();
  }
  const Eigen::HouseholderQR<Eigen::MatrixX2d> qr(start);
  const Eigen::MatrixX2d q = qr.householderQ() * Eigen::MatrixX2d::Identity(start.rows(), 2);
  residuals -= q * (q.transpose() * residuals).eval();
  slow_[index].apply(residuals);
  if (!jacobian) return;
  by_unknowns -= q * (q.transpose() * by_unknowns).eval();
  for (Eigen::Index j = 0; j < by_unknowns.cols(); ++j) slow_[index].apply(by_unknowns.col(j));
  jacobian->middleRows(row, by_unknowns.rows()) = by_unknowns;
}

PointResiduals Residuals::points(const Eigen::VectorXd& values, std::size_t index) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const std::size_t first = first_point_[index], n = point_count(index);
  const Eigen::Matrix2Xd positions = modelled_points(values, index, false).positions;
  const Eigen::MatrixX2d start = white(index);
  PointResiduals result;
  Eigen::VectorXd whitened(start.rows());
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = 2 * static_cast<Eigen::Index>(i);
    result.row.push_back(first + i);
    result.residual.push_back(run.track.position[first + i] - positions.col(static_cast<Eigen::Index>(i)));
    whitened.segment<2>(k) = start.middleRows<2>(k) * result.residual.back();
  }
  result.start_point = (start.transpose() * start).ldlt().solve(start.transpose() * whitened);
  const Eigen::VectorXd slow = slow_[index].expected(whitened - start * result.start_point);
  result.rows_taken = slow_[index].rows_taken();
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = 2 * static_cast<Eigen::Index>(i);
    result.residual[i] -= result.start_point;
    result.slow.push_back(Eigen::Matrix2d(start.middleRows<2>(k)).inverse() * slow.segment<2>(k));
  }
  return result;
}

}  // namespace tribotrack::fit::internal
