// The points of one track against a model of them: what its errors are, whitened.
//
// Errors of a track are those of single points and slow ones (PointWhitening), the unknown start point, and
// errors with shapes over the whole track, found in the residuals (correlated_errors.h). The start point is
// linear: it is projected out, so that it costs no unknown and is counted exactly.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fit/problem.h"
#include "fit/residuals/correlated_errors.h"

namespace tribotrack::fit::internal {

/// Scatter of a track's points beyond their own sigma.
struct PointScatter {
  double between_points = 0;    ///< m per axis
  double correlation_time = 1;  ///< points per independent point: weights are divided by it
};

/// Rows of one run after a fit, unwhitened.
struct PointResiduals {
  std::vector<std::size_t> row;  ///< of the track
  std::vector<Eigen::Vector2d> residual;
  /// What is left without the expected errors that have shapes over the track and without what the points
  /// before tell of its slow errors, and its covariance by the track, m^2.
  std::vector<Eigen::Vector2d> innovation;
  std::vector<Eigen::Matrix2d> innovation_covariance;
  double rows_taken = 0;  ///< degrees of freedom of that expectation
  Eigen::Vector2d start_point = Eigen::Vector2d::Zero();
};

class TrackWhitening {
 public:
  /// Refers to the run. `first`: its first point used; `variances`: of correlated errors, of driven runs
  /// alone; `reference_time`: theirs, s.
  TrackWhitening(const TrajectoryRun& run, std::size_t first, const PointScatter& scatter,
                 const CorrelatedVariances& variances, double reference_time);

  std::size_t first() const { return first_; }
  std::size_t points() const { return times_.size(); }
  const std::vector<double>& times() const { return times_; }  ///< s, of its points, from the first
  /// Measured less modelled (m, in the picture), two rows a point.
  Eigen::VectorXd difference(const Eigen::Matrix2Xd& positions) const;
  /// V^(-1/2), columns of two rows a point.
  Eigen::MatrixXd whitened(Eigen::MatrixXd columns) const;
  /// Of a sum g' V^(-1/2) y of whitened rows, g = `column`, in place: what it is of the points' own noise.
  void take_own(Eigen::Ref<Eigen::VectorXd> column) const;
  /// Shapes of correlated errors over the points; none for a free slide.
  ErrorShapes shapes(const ErrorParts& wanted) const;
  /// L^-1 of the points' own noise and slow errors, of a shift along x and along y.
  const Eigen::MatrixX2d& white() const { return white_; }
  PointResiduals explained(const Eigen::Matrix2Xd& positions) const;

 private:
  const TrajectoryRun* run_;
  std::size_t first_;
  double reference_time_;
  std::vector<double> times_;
  PointWhitening noise_;            ///< of single points, and slow
  Eigen::MatrixX2d white_, start_;  ///< behind it the start point's columns, and orthonormal ones
  Eigen::MatrixXd shaped_;          ///< columns of its own errors with shapes, not whitened
  CorrelatedWhitening correlated_;  ///< of them
};

}  // namespace tribotrack::fit::internal
