// Errors that many points of one track share.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace tribotrack::fit::internal {

/// A registered picture errs alike over many frames, and the parameters feel just that: the mean drift and
/// the circle. Every run has its own slow error, the variances are one campaign's. Per axis:
/// drift: a straight line in time (a turning part whose tracked point is not quite its centre);
/// walk: Brownian motion, by its Karhunen-Loeve modes sqrt(2 T) sin((k - 1/2) pi t/T) / ((k - 1/2) pi)
/// [Loeve, Probability Theory II, section 37.5]; circle: cos wt and sin wt; overtones: the same at 2w and 3w.
enum class SlowPart { drift, walk, circle, overtones };
constexpr std::size_t kSlowParts = 4;
constexpr std::size_t kWalkModes = 16;

/// m^2 per axis: of the drift and the walk over the reference time, of each coefficient of the sines.
using SlowVariances = std::array<double, kSlowParts>;

/// The shapes over a run's points, one column each, for both axes alike.
struct SlowShapes {
  Eigen::MatrixXd values;         ///< point x shape
  std::vector<std::size_t> part;  ///< of each shape
  std::size_t count() const { return part.size(); }
};

/// `times` of the points from the first, s; w = 0 where no platform moves; shapes of parts with
/// `wanted[part]` only.
SlowShapes slow_shapes(const std::vector<double>& times, double angular_frequency, double reference_time,
                       const std::array<bool, kSlowParts>& wanted);

/// U: the shapes in both axes behind the points' own whitening, `white` = the stack of L^-1 (LL' the points'
/// covariances, times the root of their weight), less what the unknown start point takes (the columns of
/// `white`). Column 2 j + axis is shape j.
Eigen::MatrixXd whitened_shapes(const SlowShapes& shapes, const Eigen::MatrixX2d& white);

/// (I + U G U')^(-1/2), G diagonal, through the eigenvalues l of G^(1/2) U'U G^(1/2) = R diag(l) R':
/// I - U G^(1/2) R diag((1 - (1 + l)^(-1/2)) / l) R' G^(1/2) U' (Woodbury's identity for a root).
class SlowWhitening {
 public:
  SlowWhitening() = default;
  SlowWhitening(const SlowShapes& shapes, const Eigen::MatrixX2d& white, const SlowVariances& variances);

  bool empty() const { return shapes_.cols() == 0; }
  /// In place; columns that are zero stay so.
  void apply(Eigen::Ref<Eigen::VectorXd> column) const;
  /// What the points are expected to err by slowly, given `column` (white whitening alone): U G U' V^-1
  /// column, whitened like it.
  Eigen::VectorXd expected(const Eigen::VectorXd& column) const;
  /// How many rows that takes out: sum of l/(1 + l).
  double rows_taken() const { return rows_taken_; }

 private:
  Eigen::MatrixXd shapes_;           ///< U G^(1/2) R
  Eigen::VectorXd root_, expected_;  ///< (1 - (1 + l)^(-1/2)) / l and 1/(1 + l)
  double rows_taken_ = 0;
};

}  // namespace tribotrack::fit::internal
