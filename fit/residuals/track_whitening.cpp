#include "fit/residuals/track_whitening.h"

#include <cmath>

#include "fit/tools/dense.h"
#include "fit/tools/track_errors.h"

namespace tribotrack::fit::internal {

TrackWhitening::TrackWhitening(const TrajectoryRun& run, std::size_t first, const PointScatter& scatter,
                               const CorrelatedVariances& variances, double reference_time)
    : run_(&run), first_(first), reference_time_(reference_time) {
  const TrackTable& track = run.track;
  const double added = scatter.between_points * scatter.between_points + kFinestSigma * kFinestSigma;
  std::vector<Eigen::Matrix2d> own;
  std::vector<double> slow_share;
  for (std::size_t i = first; i < track.time.size(); ++i) {
    const PointErrors errors = point_errors(track, i);
    times_.push_back(track.time[i] - track.time[first]);
    own.emplace_back(errors.own + added * Eigen::Matrix2d::Identity());
    slow_share.push_back(errors.slow);
  }
  noise_ = PointWhitening(times_, own, slow_share, track.slow, 1 / std::sqrt(scatter.correlation_time));
  white_ = noise_.shift();
  start_ = orthonormal(white_);
  ErrorParts present{};
  for (std::size_t part = 0; part < kErrorParts; ++part) present[part] = variances[part] > 0;
  const ErrorShapes found = shapes(present);
  if (found.count() == 0) return;
  shaped_ = error_columns(found);
  correlated_ =
      CorrelatedWhitening(whitened_columns(shaped_, noise_, start_), column_variances(found, variances));
}

ErrorShapes TrackWhitening::shapes(const ErrorParts& wanted) const {
  if (run_->free_slide || wanted == ErrorParts{}) return {};
  const double w = run_->scenario.drive.amplitude > 0 ? run_->scenario.drive.angular_frequency : 0;
  return error_shapes(times_, w, run_->scenario.start_phase, reference_time_, wanted);
}

Eigen::VectorXd TrackWhitening::difference(const Eigen::Matrix2Xd& positions) const {
  Eigen::VectorXd rows(positions.size());
  for (Eigen::Index i = 0; i < positions.cols(); ++i)
    rows.segment<2>(2 * i) = run_->track.position[first_ + static_cast<std::size_t>(i)] - positions.col(i);
  return rows;
}

Eigen::MatrixXd TrackWhitening::whitened(Eigen::MatrixXd columns) const {
  columns = whitened_columns(std::move(columns), noise_, start_);
  for (Eigen::Index j = 0; j < columns.cols(); ++j) correlated_.apply(columns.col(j));
  return columns;
}

void TrackWhitening::take_own(Eigen::Ref<Eigen::VectorXd> column) const {
  // The rows' covariance is root by root: V^(-1/2) = (correlated) (points), the first symmetric.
  correlated_.apply(column);
  noise_.take_own(column);
}

PointResiduals TrackWhitening::explained(const Eigen::Matrix2Xd& positions) const {
  const Eigen::Matrix2d normal = white_.transpose() * white_;
  const Eigen::VectorXd difference = this->difference(positions);
  Eigen::VectorXd white = difference;
  noise_.apply(Eigen::Ref<Eigen::VectorXd>(white));
  PointResiduals result;
  result.start_point = solve_symmetric2(normal, white_.transpose() * white);
  white -= white_ * result.start_point;
  if (!correlated_.empty()) {  // their expectation, less what a start point takes of it
    Eigen::VectorXd alone = white;
    correlated_.apply(alone);
    Eigen::VectorXd errors = shaped_ * correlated_.coefficients(alone);
    noise_.apply(Eigen::Ref<Eigen::VectorXd>(errors));
    const Eigen::Vector2d taken = solve_symmetric2(normal, white_.transpose() * errors);
    white -= errors - white_ * taken;
  }
  result.rows_taken = correlated_.rows_taken();
  for (std::size_t i = 0; i < points(); ++i) {
    const auto k = 2 * static_cast<Eigen::Index>(i);
    result.row.push_back(first_ + i);
    result.residual.emplace_back(difference.segment<2>(k) - result.start_point);
    result.innovation.push_back(noise_.innovation(i, white.segment<2>(k)));
    result.innovation_covariance.emplace_back(point_errors(run_->track, first_ + i).own +
                                              noise_.predicted(i));
  }
  return result;
}

}  // namespace tribotrack::fit::internal
