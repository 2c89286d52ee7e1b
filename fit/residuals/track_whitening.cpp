#include "fit/residuals/track_whitening.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "fit/tools/dense.h"
#include "fit/tools/track_errors.h"

namespace tribotrack::fit::internal {
namespace {

using std::numbers::pi;

std::size_t index(ErrorPart part) {
  return static_cast<std::size_t>(part);
}

}  // namespace

ErrorShapes error_shapes(const std::vector<double>& times, double w, double start_phase,
                         double reference_time, const ErrorParts& wanted) {
  ErrorShapes shapes;
  const auto n = static_cast<Eigen::Index>(times.size());
  const Eigen::ArrayXd t = Eigen::Map<const Eigen::ArrayXd>(times.data(), n);
  const double duration = times.back();
  constexpr auto kMost = static_cast<Eigen::Index>(1 + kWalkModes + 6);
  Eigen::MatrixXd columns(n, kMost);
  const auto add = [&](ErrorPart part, const auto& column) {
    if (!wanted[index(part)]) return;
    columns.col(static_cast<Eigen::Index>(shapes.part.size())) = column;
    shapes.part.push_back(index(part));
  };
  add(ErrorPart::drift, (t - 0.5 * duration) / reference_time);
  for (std::size_t k = 1; k <= kWalkModes; ++k) {
    const double rate = (static_cast<double>(k) - 0.5) * pi;
    add(ErrorPart::walk, std::sqrt(2 * duration / reference_time) / rate * (rate / duration * t).sin());
  }
  for (int order = 1; order <= 3 && w > 0; ++order) {
    const ErrorPart part = order == 1 ? ErrorPart::circle : ErrorPart::overtones;
    add(part, (order * (start_phase + w * t)).cos());
    add(part, (order * (start_phase + w * t)).sin());
  }
  shapes.values = columns.leftCols(static_cast<Eigen::Index>(shapes.part.size()));
  return shapes;
}

Eigen::MatrixXd error_columns(const ErrorShapes& shapes) {
  const Eigen::Index points = shapes.values.rows();
  Eigen::MatrixXd columns(2 * points, 2 * shapes.values.cols());
  for (Eigen::Index j = 0; j < shapes.values.cols(); ++j)
    for (Eigen::Index i = 0; i < points; ++i)
      columns.block<2, 2>(2 * i, 2 * j) = shapes.values(i, j) * Eigen::Matrix2d::Identity();
  return columns;
}

Eigen::MatrixXd whitened_columns(Eigen::MatrixXd columns, const PointWhitening& points,
                                 const Eigen::MatrixX2d& start) {
  points.apply(columns);
  columns -= start * (start.transpose() * columns).eval();
  return columns;
}

Eigen::VectorXd column_variances(const ErrorShapes& shapes, const CorrelatedVariances& variances) {
  Eigen::VectorXd result(2 * static_cast<Eigen::Index>(shapes.count()));
  for (std::size_t j = 0; j < shapes.count(); ++j)
    result.segment<2>(2 * static_cast<Eigen::Index>(j)).setConstant(variances[shapes.part[j]]);
  return result;
}

CorrelatedWhitening::CorrelatedWhitening(Eigen::MatrixXd shapes, const Eigen::VectorXd& variances)
    : shapes_(std::move(shapes)) {
  const Eigen::VectorXd roots = variances.cwiseSqrt();
  shapes_ = (shapes_ * roots.asDiagonal()).eval();
  const EigenSystem eigen = eigen_symmetric(shapes_.transpose() * shapes_);
  const Eigen::ArrayXd l = eigen.values.array().max(0);
  shapes_ = (shapes_ * eigen.vectors).eval();
  turned_ = roots.asDiagonal() * eigen.vectors;
  // (1 - 1/s)/(s^2 - 1) with s^2 = 1 + l, without its cancellation.
  const Eigen::ArrayXd s = (1 + l).sqrt();
  root_ = (1 / (s * (s + 1))).matrix();
  expected_ = (1 / (1 + l)).matrix();
  rows_taken_ = (l / (1 + l)).sum();
}

void CorrelatedWhitening::apply(Eigen::Ref<Eigen::VectorXd> column) const {
  if (empty() || column.isZero(0)) return;
  const Eigen::VectorXd along = root_.cwiseProduct(shapes_.transpose() * column);
  column.noalias() -= shapes_ * along;
}

// With S = U G^(1/2) R, S'S = diag(l), and x = V^(-1/2) y: S' V^-1 y = S' V^(-1/2) x = diag((1 + l)^(-1/2))
// S' x.
Eigen::VectorXd CorrelatedWhitening::coefficients(const Eigen::VectorXd& whitened) const {
  return turned_ * expected_.cwiseSqrt().cwiseProduct(shapes_.transpose() * whitened);
}

namespace {

/// The state: two coordinates of every slow error, one error after the other.
Eigen::MatrixXd repeated(double share, Eigen::Index processes) {
  return share * Eigen::Matrix2d::Identity().replicate(1, processes);
}

}  // namespace

PointWhitening::PointWhitening(const std::vector<double>& times, const std::vector<Eigen::Matrix2d>& own,
                               const std::vector<double>& slow_share, const std::vector<SlowError>& all_slow,
                               double factor) {
  std::vector<SlowError> slow;
  std::ranges::copy_if(all_slow, std::back_inserter(slow), [](const SlowError& s) { return s.sd > 0; });
  slow_ = slow.size();
  const auto size = 2 * static_cast<Eigen::Index>(slow_);
  Eigen::VectorXd stationary(size);
  for (Eigen::Index k = 0; k < size; ++k)
    stationary(k) = std::pow(slow[static_cast<std::size_t>(k / 2)].sd, 2);
  Eigen::MatrixXd covariance = stationary.asDiagonal();  // of the state, given all points before
  for (std::size_t i = 0; i < times.size(); ++i) {
    const Eigen::MatrixXd seen = repeated(slow_share[i], size / 2);
    Point& point = points_.emplace_back();
    point.share = slow_share[i];
    point.predicted = seen * covariance * seen.transpose();
    const Eigen::Matrix2d whole = own[i] + point.predicted;
    point.white = factor * Factor2(whole).inverse_lower();
    point.own = Factor2(own[i]).lower() / factor;
    if (slow_ == 0) continue;
    const Eigen::MatrixXd gain = solve_symmetric2(whole, seen * covariance).transpose();
    const Eigen::MatrixXd left = Eigen::MatrixXd::Identity(size, size) - gain * seen;
    // Joseph's form, which stays positive.
    covariance = (left * covariance * left.transpose() + gain * own[i] * gain.transpose()).eval();
    const double step = i + 1 < times.size() ? times[i + 1] - times[i] : 0;
    Eigen::VectorXd decay(size);
    for (std::size_t p = 0; p < slow_; ++p) {
      const auto k = 2 * static_cast<Eigen::Index>(p);
      decay.segment<2>(k).setConstant(std::exp(-step / slow[p].time));
      gains_.push_back({decay(k) * gain.middleRows<2>(k), decay(k)});
    }
    covariance = (decay.asDiagonal() * covariance * decay.asDiagonal()).eval();
    for (Eigen::Index k = 0; k < size; ++k)
      covariance(k, k) -= stationary(k) * std::expm1(-2 * step / slow[static_cast<std::size_t>(k / 2)].time);
  }
}

void PointWhitening::apply(Eigen::Ref<Eigen::MatrixXd> columns) const {
  for (auto column : columns.colwise()) {
    std::vector<Eigen::Vector2d> state(slow_, Eigen::Vector2d::Zero());
    const Gain* gain = gains_.data();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      auto here = column.segment<2>(2 * static_cast<Eigen::Index>(i));
      Eigen::Vector2d innovation = here;
      for (const Eigen::Vector2d& x : state) innovation -= points_[i].share * x;
      here = points_[i].white * innovation;
      for (Eigen::Vector2d& x : state) {
        x = gain->decay * x + gain->gain * innovation;
        ++gain;
      }
    }
  }
}

// The transpose of apply(), from the last point to the first: `moves` is how the sum goes with the state.
void PointWhitening::take_own(Eigen::Ref<Eigen::VectorXd> column) const {
  if (slow_ == 0) return;
  std::vector<Eigen::Vector2d> moves(slow_, Eigen::Vector2d::Zero());
  for (std::size_t i = points_.size(); i-- > 0;) {
    auto here = column.segment<2>(2 * static_cast<Eigen::Index>(i));
    const Gain* gain = gains_.data() + i * slow_;
    Eigen::Vector2d by_point = points_[i].white.transpose() * here;
    for (std::size_t p = 0; p < slow_; ++p) by_point += gain[p].gain.transpose() * moves[p];
    for (std::size_t p = 0; p < slow_; ++p) moves[p] = gain[p].decay * moves[p] - points_[i].share * by_point;
    here = points_[i].own.transpose() * by_point;
  }
}

Eigen::MatrixX2d PointWhitening::shift() const {
  Eigen::MatrixX2d columns = Eigen::Matrix2d::Identity().replicate(rows() / 2, 1);
  apply(columns);
  return columns;
}

Eigen::Vector2d PointWhitening::innovation(std::size_t point, const Eigen::Vector2d& whitened) const {
  return points_[point].white.triangularView<Eigen::Lower>().solve(whitened);
}

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
  noise_.apply(white);
  PointResiduals result;
  result.start_point = solve_symmetric2(normal, white_.transpose() * white);
  white -= white_ * result.start_point;
  if (!correlated_.empty()) {  // their expectation, less what a start point takes of it
    Eigen::VectorXd alone = white;
    correlated_.apply(alone);
    Eigen::VectorXd errors = shaped_ * correlated_.coefficients(alone);
    noise_.apply(errors);
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
