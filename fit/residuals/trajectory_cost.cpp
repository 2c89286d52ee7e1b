// Every tracked point against the model's dense trajectory. The start point is linear: it is projected out,
// so that it costs no unknown and is counted exactly.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

#include "fit/residuals/residuals.h"
#include "fit/tools/parallel.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kFinestSigma = 1e-9;  ///< m; no camera sees less

}  // namespace

PointModel Residuals::modelled_points(const Eigen::VectorXd& values, std::size_t index,
                                      bool derivatives) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const AppliedScenario applied = run.free_slide ? unknowns_->apply_free_slide(values, index, derivatives)
                                                 : unknowns_->apply_trajectory(values, index, derivatives);
  const bool camera_frame = !run.free_slide && !run.track.platform_frame;
  return model_points(*unknowns_, applied, prepared_[index]->times, {camera_frame, run.track.exposure},
                      tolerance_, derivatives);
}

ErrorShapes Residuals::shapes(std::size_t index, const ErrorParts& wanted) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  if (run.free_slide) return {};
  const double w = run.scenario.drive.amplitude > 0 ? run.scenario.drive.angular_frequency : 0;
  ErrorShapes shapes =
      error_shapes(prepared_[index]->times, w, run.scenario.start_phase, reference_time_, wanted);
  const Eigen::Vector2d way = run.track.position.back() - run.track.position.front();
  if (way.norm() > 0) shapes.way = way.normalized();
  return shapes;
}

void Residuals::prepare() {
  parallel_for(prepared_.size(), threads_, [&](std::size_t run) { prepare(run); });
  prepare_common();
}

/// (I + U G U')^(-1/2) behind the runs' own whitening, U their shapes one below the other.
void Residuals::prepare_common() {
  common_.reset();
  Eigen::Index columns = 0;
  const Prepared* like = nullptr;
  for (const auto& prepared : prepared_)
    if (prepared->common.count() > 0) {
      like = prepared.get();
      columns = 2 * static_cast<Eigen::Index>(prepared->common.count());
    }
  if (!like) return;
  const Eigen::Index first = trajectory_row(0);
  Eigen::MatrixXd stacked = Eigen::MatrixXd::Zero(trajectory_row(prepared_.size()) - first, columns);
  for (std::size_t i = 0; i < prepared_.size(); ++i) {
    const Prepared& prepared = *prepared_[i];
    if (prepared.common.count() == 0) continue;
    auto rows = stacked.middleRows(trajectory_row(i) - first, prepared.white.rows());
    rows = whitened_shapes(prepared.common, prepared.white);
    for (Eigen::Index j = 0; j < columns; ++j) prepared.correlated.apply(rows.col(j));
  }
  common_ = std::make_shared<CorrelatedWhitening>(std::move(stacked),
                                                  column_variances(like->common, scatter_.correlated));
}

Eigen::VectorXd Residuals::common_error(const Eigen::VectorXd& values) const {
  Eigen::VectorXd residuals;
  if (!common_ || !evaluate(values, residuals, nullptr)) return {};
  const Eigen::Index first = trajectory_row(0);
  return common_->coefficients(residuals.segment(first, trajectory_row(prepared_.size()) - first));
}

void Residuals::prepare(std::size_t index) {
  const auto& track = problem_->trajectory_runs[index].track;
  const auto& scatter = scatter_.trajectories[index];
  const double added = scatter.between_points * scatter.between_points + kFinestSigma * kFinestSigma;
  const double uncorrelated = 1 / std::sqrt(scatter.correlation_time);
  const std::size_t first = first_point_[index], n = point_count(index);
  auto prepared = std::make_shared<Prepared>();
  prepared->white.resize(2 * static_cast<Eigen::Index>(n), 2);
  for (std::size_t i = 0; i < n; ++i) {
    prepared->times.push_back(track.time[first + i] - track.time[first]);
    const Eigen::LLT<Eigen::Matrix2d> factor(
        Eigen::Matrix2d(track.covariance[first + i] + added * Eigen::Matrix2d::Identity()));
    prepared->white.middleRows<2>(2 * static_cast<Eigen::Index>(i)) =
        uncorrelated * std::sqrt(point_weight(index, i)) *
        factor.matrixL().solve(Eigen::Matrix2d::Identity()).eval();
  }
  const Eigen::HouseholderQR<Eigen::MatrixX2d> qr(prepared->white);
  prepared->start = qr.householderQ() * Eigen::MatrixX2d::Identity(prepared->white.rows(), 2);
  prepared_[index] = prepared;  // for shapes()
  if (scatter_.correlated == CorrelatedVariances{}) return;
  ErrorParts own{}, shared{};
  for (std::size_t part = 0; part < kErrorParts; ++part)
    (is_common(part) ? shared : own)[part] = scatter_.correlated[part] > 0;
  prepared->common = shapes(index, shared);
  if (const ErrorShapes correlated = shapes(index, own); correlated.count() > 0)
    prepared->correlated = CorrelatedWhitening(whitened_shapes(correlated, prepared->white),
                                               column_variances(correlated, scatter_.correlated));
}

void Residuals::whiten(std::size_t index, const Eigen::Matrix2Xd& positions,
                       Eigen::Ref<Eigen::VectorXd> rows) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const Prepared& prepared = *prepared_[index];
  const std::size_t first = first_point_[index];
  for (Eigen::Index i = 0; i < positions.cols(); ++i)
    rows.segment<2>(2 * i) = prepared.white.middleRows<2>(2 * i) *
                             (run.track.position[first + static_cast<std::size_t>(i)] - positions.col(i));
  rows -= prepared.start * (prepared.start.transpose() * rows).eval();
  prepared.correlated.apply(rows);
}

void Residuals::whiten_common(Eigen::Ref<Eigen::VectorXd> column) const {
  const Eigen::Index first = trajectory_row(0), rows = trajectory_row(prepared_.size()) - first;
  if (common_) common_->apply(column.segment(first, rows));
}

void Residuals::whiten_shared(Eigen::Ref<Eigen::VectorXd> column) const {
  // The rows' covariance is root by root: V^(-1/2) = (common) (own) (points), each root symmetric.
  if (common_) common_->apply(column);
  const Eigen::Index first = trajectory_row(0);
  for (std::size_t i = 0; i < prepared_.size(); ++i)
    prepared_[i]->correlated.apply(
        column.segment(trajectory_row(i) - first, 2 * static_cast<Eigen::Index>(point_count(i))));
}

void Residuals::trajectory(const Eigen::VectorXd& values, std::size_t index,
                           Eigen::Ref<Eigen::VectorXd> residuals, Eigen::MatrixXd* jacobian,
                           Eigen::Index row) const {
  PointModel modelled = modelled_points(values, index, jacobian != nullptr);
  whiten(index, modelled.positions, residuals);
  if (!jacobian) return;
  const Prepared& prepared = *prepared_[index];
  const Eigen::MatrixX2d& q = prepared.start;
  Eigen::MatrixXd& by_unknowns = modelled.jacobian;
  for (Eigen::Index j = 0; j < by_unknowns.cols(); ++j) {
    auto column = by_unknowns.col(j);
    if (column.isZero(0)) continue;
    for (Eigen::Index k = 0; k < column.size(); k += 2)
      column.segment<2>(k) = -(prepared.white.middleRows<2>(k) * column.segment<2>(k)).eval();
    column -= q * (q.transpose() * column).eval();
    prepared.correlated.apply(column);
    jacobian->col(j).segment(row, column.size()) = column;
  }
}

PointResiduals Residuals::points(const Eigen::VectorXd& values, std::size_t index,
                                 const Eigen::VectorXd& common) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const std::size_t first = first_point_[index], n = point_count(index);
  const Eigen::Matrix2Xd positions = modelled_points(values, index, false).positions;
  const Eigen::MatrixX2d& start = white(index);
  const CorrelatedWhitening& correlated_errors = prepared_[index]->correlated;
  PointResiduals result;
  Eigen::VectorXd whitened(start.rows());
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = 2 * static_cast<Eigen::Index>(i);
    result.row.push_back(first + i);
    result.residual.push_back(run.track.position[first + i] - positions.col(static_cast<Eigen::Index>(i)));
    whitened.segment<2>(k) = start.middleRows<2>(k) * result.residual.back();
  }
  result.start_point = (start.transpose() * start).ldlt().solve(start.transpose() * whitened);
  Eigen::VectorXd shared = Eigen::VectorXd::Zero(whitened.size());
  if (common.size() > 0 && prepared_[index]->common.count() > 0)
    shared = whitened_shapes(prepared_[index]->common, start) * common;
  const Eigen::VectorXd correlated =
      shared + correlated_errors.expected(whitened - start * result.start_point - shared);
  result.rows_taken = correlated_errors.rows_taken();
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = 2 * static_cast<Eigen::Index>(i);
    result.residual[i] -= result.start_point;
    result.correlated.push_back(Eigen::Matrix2d(start.middleRows<2>(k)).inverse() * correlated.segment<2>(k));
  }
  return result;
}

}  // namespace tribotrack::fit::internal
