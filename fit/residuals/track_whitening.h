// The points of one track against a model of them: what its errors are, whitened.
//
// Errors of a track are those of single points and slow ones (PointWhitening), the unknown start point, and
// errors with shapes over the whole track, found in the residuals (ErrorPart). The start point is linear: it
// is projected out, so that it costs no unknown and is counted exactly.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "fit/problem.h"
#include "fit/track_table.h"

namespace tribotrack::fit::internal {

inline constexpr double kFinestSigma = 1e-9;  ///< m, added to the points' own noise: no camera sees less

/// V = diag(own_i) + a_i a_j sum_p s_p^2 exp(-|t_i - t_j|/T_p) I of two coordinates a point. The slow errors
/// are the state of a linear system, x_p(t_i) = exp(-dt/T_p) x_p(t_(i-1)) + noise, seen in y_i = a_i sum_p
/// x_p
/// + own noise. Kalman's innovations y_i - E(y_i | y_1 .. y_(i-1)), each divided by the root of its
/// covariance, are L^-1 y with V = L L' by Cholesky, at a cost that grows with the number of points
/// [Schweppe, IEEE Trans. Inf. Theory 11 (1965) 61; Harvey, Forecasting, Structural Time Series Models and
/// the Kalman Filter, 3.4]. Without slow errors it is each point's own L^-1.
class PointWhitening {
 public:
  PointWhitening() = default;
  /// `times` increase; `own` and `slow_share`, the a_i, for each of them. Rows are multiplied by `factor`.
  PointWhitening(const std::vector<double>& times, const std::vector<Eigen::Matrix2d>& own,
                 const std::vector<double>& slow_share, const std::vector<SlowError>& slow,
                 double factor = 1);

  Eigen::Index rows() const { return 2 * static_cast<Eigen::Index>(points_.size()); }
  /// L^-1 columns, in place.
  void apply(Eigen::Ref<Eigen::MatrixXd> columns) const;
  /// Of a sum g' L^-1 y of whitened rows, g = `column`, in place: what it is of the points' own noise, in
  /// units of its sd, so that the squares of g add up to the sum's variance and those that are left to what
  /// of it is the points' own.
  void take_own(Eigen::Ref<Eigen::VectorXd> column) const;
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

// clang-format off
/// Registration errors are similar over many frames, and it is their slow part (mean drift, circle) that moves
/// the parameters. Every run has its own; all runs of a campaign have the same variances. Per axis:
///   drift      a straight line in time (a rotating part whose tracked point is not its centre)
///   walk       Brownian motion by its Karhunen-Loeve modes sqrt(2 T) sin((k - 1/2) pi t/T) / ((k - 1/2) pi)
///              [Loeve, Probability Theory II, section 37.5]
///   circle     cos and sin of the platform's phase
///   overtones  the same of its second and third multiple
/// What all runs share of them are errors of the platform's motion and the scale: conditions of the fit.
// clang-format on
enum class ErrorPart { drift, walk, circle, overtones };
constexpr std::size_t kErrorParts = 4;
constexpr std::size_t kWalkModes = 16;

/// m^2 per axis: of the drift and the walk over the reference time, of each coefficient of the sines.
using CorrelatedVariances = std::array<double, kErrorParts>;

/// The shapes over a run's points, one column each, the same for both axes.
struct ErrorShapes {
  Eigen::MatrixXd values;         ///< point x shape
  std::vector<std::size_t> part;  ///< of each shape
  std::size_t count() const { return part.size(); }
};

/// A choice of parts.
using ErrorParts = std::array<bool, kErrorParts>;
constexpr ErrorParts kAllParts{true, true, true, true};

/// `times` of the points from the first, s, where the platform's phase is `start_phase`; w = 0 where no
/// platform moves; shapes of parts with `wanted[part]` only.
ErrorShapes error_shapes(const std::vector<double>& times, double angular_frequency, double start_phase,
                         double reference_time, const ErrorParts& wanted);

/// The shapes in both axes, two rows a point: column 2 j is shape j along x, 2 j + 1 along y.
Eigen::MatrixXd error_columns(const ErrorShapes& shapes);

/// U: such columns behind the points' own whitening, the unknown start point, which `start` spans behind it
/// with orthonormal columns, projected out.
Eigen::MatrixXd whitened_columns(Eigen::MatrixXd columns, const PointWhitening& points,
                                 const Eigen::MatrixX2d& start);

/// (I + U G U')^(-1/2), G diagonal, through the eigenvalues l of G^(1/2) U'U G^(1/2) = R diag(l) R':
/// I - U G^(1/2) R diag((1 - (1 + l)^(-1/2)) / l) R' G^(1/2) U' (Woodbury's identity for a root).
class CorrelatedWhitening {
 public:
  CorrelatedWhitening() = default;
  /// U = `shapes`, whitened by the rest of the covariance, and the diagonal of G.
  CorrelatedWhitening(Eigen::MatrixXd shapes, const Eigen::VectorXd& variances);

  bool empty() const { return shapes_.cols() == 0; }
  /// In place; columns that are zero stay so.
  void apply(Eigen::Ref<Eigen::VectorXd> column) const;
  /// The expected coefficients of the shapes, G U' V^-1 column, given V^(-1/2) column.
  Eigen::VectorXd coefficients(const Eigen::VectorXd& whitened) const;
  /// The degrees of freedom of that expectation: sum of l/(1 + l).
  double rows_taken() const { return rows_taken_; }

 private:
  Eigen::MatrixXd shapes_;           ///< U G^(1/2) R
  Eigen::MatrixXd turned_;           ///< G^(1/2) R
  Eigen::VectorXd root_, expected_;  ///< (1 - (1 + l)^(-1/2)) / l and 1/(1 + l)
  double rows_taken_ = 0;
};

/// Of the shapes' columns in error_columns().
Eigen::VectorXd column_variances(const ErrorShapes& shapes, const CorrelatedVariances& variances);

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
