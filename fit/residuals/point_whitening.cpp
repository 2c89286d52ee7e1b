#include "fit/residuals/point_whitening.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "fit/tools/dense.h"

namespace tribotrack::fit::internal {
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

void PointWhitening::apply(Eigen::Ref<Eigen::VectorXd> column) const {
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

void PointWhitening::colour(Eigen::Ref<Eigen::VectorXd> column) const {
  std::vector<Eigen::Vector2d> state(slow_, Eigen::Vector2d::Zero());
  const Gain* gain = gains_.data();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    auto here = column.segment<2>(2 * static_cast<Eigen::Index>(i));
    const Eigen::Vector2d innovation = this->innovation(i, here);
    here = innovation;
    for (Eigen::Vector2d& x : state) {
      here += points_[i].share * x;
      x = gain->decay * x + gain->gain * innovation;
      ++gain;
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

void PointWhitening::apply(Eigen::Ref<Eigen::MatrixXd> columns) const {
  for (Eigen::Index j = 0; j < columns.cols(); ++j) apply(Eigen::Ref<Eigen::VectorXd>(columns.col(j)));
}

Eigen::MatrixX2d PointWhitening::shift() const {
  Eigen::MatrixX2d columns = Eigen::Matrix2d::Identity().replicate(rows() / 2, 1);
  for (Eigen::Index j = 0; j < 2; ++j) apply(Eigen::Ref<Eigen::VectorXd>(columns.col(j)));
  return columns;
}

Eigen::Vector2d PointWhitening::innovation(std::size_t point, const Eigen::Vector2d& whitened) const {
  return points_[point].white.triangularView<Eigen::Lower>().solve(whitened);
}

}  // namespace tribotrack::fit::internal
