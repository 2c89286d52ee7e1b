// Every tracked point against the model's dense trajectory. The start point is linear: it is projected out,
// so that it costs no unknown and is counted exactly.
#include <cmath>
#include <utility>

#include "fit/residuals/residuals.h"
#include "fit/tools/dense.h"
#include "fit/tools/track_errors.h"
#include "model/parallel.h"

namespace tribotrack::fit::internal {
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
    stacked.middleRows(trajectory_row(i) - first, prepared.white.rows()) =
        whitened(i, error_columns(prepared.common));
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
  const std::size_t first = first_point_[index], n = point_count(index);
  auto prepared = std::make_shared<Prepared>();
  std::vector<Eigen::Matrix2d> own;
  std::vector<double> slow_share;
  prepared->own.resize(2 * static_cast<Eigen::Index>(n),
                       track.shared.empty() ? 0 : track.shared.front().cols());
  for (std::size_t i = 0; i < n; ++i) {
    const PointErrors errors = point_errors(track, first + i);
    prepared->times.push_back(track.time[first + i] - track.time[first]);
    own.emplace_back((errors.own + added * Eigen::Matrix2d::Identity()) / point_weight(index, i));
    slow_share.push_back(errors.slow);
    if (prepared->own.cols() > 0)  // a matrix without columns has no storage that rows could be found in
      prepared->own.middleRows<2>(2 * static_cast<Eigen::Index>(i)) = errors.all;
  }
  prepared->points =
      PointWhitening(prepared->times, own, slow_share, track.slow, 1 / std::sqrt(scatter.correlation_time));
  prepared->white = prepared->points.shift();
  prepared->start = orthonormal(prepared->white);
  prepared_[index] = prepared;  // for shapes()
  ErrorParts separate{}, common{};
  for (std::size_t part = 0; part < kErrorParts; ++part)
    (is_common(part) ? common : separate)[part] = scatter_.correlated[part] > 0;
  const bool any = scatter_.correlated != CorrelatedVariances{};
  if (any) prepared->common = shapes(index, common);
  const ErrorShapes correlated = any ? shapes(index, separate) : ErrorShapes{};
  const Eigen::Index told = prepared->own.cols(), found = 2 * static_cast<Eigen::Index>(correlated.count());
  if (told + found == 0) return;
  Eigen::VectorXd variances = Eigen::VectorXd::Ones(told + found);
  if (found > 0) {
    prepared->own.conservativeResize(Eigen::NoChange, told + found);
    prepared->own.rightCols(found) = error_columns(correlated);
    variances.tail(found) = column_variances(correlated, scatter_.correlated);
  }
  prepared->correlated =
      CorrelatedWhitening(whitened_columns(prepared->own, prepared->points, prepared->start), variances);
}

Eigen::MatrixXd Residuals::whitened(std::size_t index, Eigen::MatrixXd columns) const {
  const Prepared& prepared = *prepared_[index];
  columns = whitened_columns(std::move(columns), prepared.points, prepared.start);
  for (Eigen::Index j = 0; j < columns.cols(); ++j) prepared.correlated.apply(columns.col(j));
  return columns;
}

void Residuals::whiten(std::size_t index, const Eigen::Matrix2Xd& positions,
                       Eigen::Ref<Eigen::VectorXd> rows) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const Prepared& prepared = *prepared_[index];
  const std::size_t first = first_point_[index];
  for (Eigen::Index i = 0; i < positions.cols(); ++i)
    rows.segment<2>(2 * i) = run.track.position[first + static_cast<std::size_t>(i)] - positions.col(i);
  prepared.points.apply(rows);
  rows -= prepared.start * (prepared.start.transpose() * rows).eval();
  prepared.correlated.apply(rows);
}

void Residuals::whiten_common(Eigen::Ref<Eigen::VectorXd> column) const {
  const Eigen::Index first = trajectory_row(0), rows = trajectory_row(prepared_.size()) - first;
  if (common_) common_->apply(column.segment(first, rows));
}

void Residuals::whiten_shared(Eigen::Ref<Eigen::VectorXd> column) const {
  // The rows' covariance is root by root: V^(-1/2) = (common) (own) (points), the first two symmetric.
  if (common_) common_->apply(column);
  const Eigen::Index first = trajectory_row(0);
  for (std::size_t i = 0; i < prepared_.size(); ++i) {
    auto rows = column.segment(trajectory_row(i) - first, 2 * static_cast<Eigen::Index>(point_count(i)));
    prepared_[i]->correlated.apply(rows);
    prepared_[i]->points.take_own(rows);
  }
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
    column *= -1;
    prepared.points.apply(Eigen::Ref<Eigen::VectorXd>(column));
    column -= q * (q.transpose() * column).eval();
    prepared.correlated.apply(column);
    jacobian->col(j).segment(row, column.size()) = column;
  }
}

PointResiduals Residuals::points(const Eigen::VectorXd& values, std::size_t index,
                                 const Eigen::VectorXd& common) const {
  const auto& track = problem_->trajectory_runs[index].track;
  const Prepared& prepared = *prepared_[index];
  const std::size_t first = first_point_[index], n = point_count(index);
  const Eigen::Matrix2Xd positions = modelled_points(values, index, false).positions;
  const Eigen::MatrixX2d& start = prepared.white;
  const Eigen::Matrix2d normal = start.transpose() * start;
  PointResiduals result;
  Eigen::VectorXd white(start.rows());
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    result.row.push_back(first + i);
    result.residual.push_back(track.position[first + i] - positions.col(k));
    white.segment<2>(2 * k) = result.residual.back();
  }
  prepared.points.apply(Eigen::Ref<Eigen::VectorXd>(white));
  result.start_point = solve_symmetric2(normal, start.transpose() * white);
  white -= start * result.start_point;
  // What the points share, less what a start point takes of it: as it is and whitened.
  Eigen::VectorXd shared = Eigen::VectorXd::Zero(white.size());
  const auto subtract = [&](const Eigen::MatrixXd& columns, const Eigen::VectorXd& coefficients) {
    Eigen::VectorXd errors = columns * coefficients, whitened_errors = errors;
    prepared.points.apply(Eigen::Ref<Eigen::VectorXd>(whitened_errors));
    const Eigen::Vector2d taken = solve_symmetric2(normal, start.transpose() * whitened_errors);
    shared += errors - taken.replicate(static_cast<Eigen::Index>(n), 1);
    white -= whitened_errors - start * taken;
  };
  if (common.size() > 0 && prepared.common.count() > 0) subtract(error_columns(prepared.common), common);
  if (!prepared.correlated.empty()) {
    Eigen::VectorXd alone = white;
    prepared.correlated.apply(alone);
    subtract(prepared.own, prepared.correlated.coefficients(alone));
  }
  result.rows_taken = prepared.correlated.rows_taken();
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = 2 * static_cast<Eigen::Index>(i);
    result.residual[i] -= result.start_point;
    result.correlated.emplace_back(shared.segment<2>(k));
    result.innovation.push_back(prepared.points.innovation(i, white.segment<2>(k)));
    result.innovation_covariance.emplace_back(point_errors(track, first + i).own +
                                              prepared.points.predicted(i));
  }
  return result;
}

}  // namespace tribotrack::fit::internal
