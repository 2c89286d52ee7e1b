// Whitening of a track's points whose errors are white noise and slow processes.
//
// V = diag(own_i) + a_i a_j sum_p s_p^2 exp(-|t_i - t_j|/T_p) I of two coordinates a point. The slow errors
// are the state of a linear system, x_p(t_i) = exp(-dt/T_p) x_p(t_(i-1)) + noise, seen in y_i = a_i sum_p x_p
// + own noise. Kalman's innovations y_i - E(y_i | y_1 .. y_(i-1)), each divided by the root of its
// covariance, are L^-1 y with V = L L' by Cholesky, at a cost that grows with the number of points [Schweppe,
// IEEE Trans. Inf. Theory 11 (1965) 61; Harvey, Forecasting, Structural Time Series Models and the Kalman
// Filter, 3.4]. Without slow errors it is each point's own L^-1.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fit/track_table.h"

namespace tribotrack::fit::internal {

inline constexpr double kFinestSigma = 1e-9;  ///< m, added to the points' own noise: no camera sees less

class PointWhitening {
 public:
  PointWhitening() = default;
  /// `times` increase; `own` and `slow_share`, the a_i, for each of them. Rows are multiplied by `factor`.
  PointWhitening(const std::vector<double>& times, const std::vector<Eigen::Matrix2d>& own,
                 const std::vector<double>& slow_share, const std::vector<SlowError>& slow,
                 double factor = 1);

  Eigen::Index rows() const { return 2 * static_cast<Eigen::Index>(points_.size()); }
  /// L^-1 column, in place.
  void apply(Eigen::Ref<Eigen::VectorXd> column) const;
  /// Of a sum g' L^-1 y of whitened rows, g = `column`, in place: what it is of the points' own noise, in
  /// units of its sd, so that the squares of g add up to the sum's variance and those that are left to what
  /// of it is the points' own.
  void take_own(Eigen::Ref<Eigen::VectorXd> column) const;
  /// L^-1 for all columns of a matrix.
  void apply(Eigen::Ref<Eigen::MatrixXd> columns) const;
  /// Columns of a shift of all points along x and along y.
  Eigen::MatrixX2d shift() const;

  /// Of the innovations of whitened points: what they are in m, and the slow part of their covariance, m^2.
  Eigen::Vector2d innovation(std::size_t point, const Eigen::Vector2d& whitened) const;
  const Eigen::Matrix2d& predicted(std::size_t point) const { return points_[point].predicted; }

 private:
  struct Point {
    Eigen::Matrix2d white;      ///< L^-1 of the innovation, times the factor
    Eigen::Matrix2d own;        ///< lower root of its own noise over the factor
    Eigen::Matrix2d predicted;  ///< a^2 times the covariance of the slow errors given all points before
    double share = 1;           ///< a
  };
  /// What an innovation tells of a slow error at the next point, and what is left of it until then.
  struct Gain {
    Eigen::Matrix2d gain;
    double decay = 0;
  };
  std::vector<Point> points_;
  std::vector<Gain> gains_;  ///< `slow_` for each point
  std::size_t slow_ = 0;
};

}  // namespace tribotrack::fit::internal
