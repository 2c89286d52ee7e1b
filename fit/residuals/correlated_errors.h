// Errors that many points of one track share.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace tribotrack::fit::internal {

/// A registered picture errs alike over many frames, and the parameters feel just that: the mean drift and
/// the circle. The variances are one campaign's. Every run has its own slow error of the first four parts,
/// the last three are one error for all runs (one camera, one platform: what is seen of a circle is too small
/// by the same share every time, what is seen of a way short by the same piece). Per axis:
/// drift: a straight line in time (a turning part whose tracked point is not quite its centre);
/// walk: Brownian motion, by its Karhunen-Loeve modes sqrt(2 T) sin((k - 1/2) pi t/T) / ((k - 1/2) pi)
/// [Loeve, Probability Theory II, section 37.5]; circle: cos and sin of the platform's phase; overtones: the
/// same of its second and third multiple. A drift that runs share is one along and one across the way that
/// each of them goes.
enum class SlowPart { drift, walk, circle, overtones, common_circle, common_overtones, common_drift };
constexpr std::size_t kSlowParts = 7;
constexpr bool is_common(std::size_t part) {
  return part >= static_cast<std::size_t>(SlowPart::common_circle);
}
constexpr std::size_t kWalkModes = 16;

/// m^2 per axis: of the drift and the walk over the reference time, of each coefficient of the sines.
using SlowVariances = std::array<double, kSlowParts>;

/// The shapes over a run's points, one column each, for both axes alike.
struct SlowShapes {
  Eigen::MatrixXd values;         ///< point x shape
  std::vector<std::size_t> part;  ///< of each shape
  Eigen::Vector2d way{1, 0};      ///< unit vector: where the run goes
  /// The axes of shape j's two coefficients, in columns: along and across the way for a common drift, else x
  /// and y.
  Eigen::Matrix2d axes(std::size_t j) const;
  std::size_t count() const { return part.size(); }
};

/// Which parts are asked for.
using SlowWanted = std::array<bool, kSlowParts>;
constexpr SlowWanted kOwnSlowParts{true, true, true, true, false, false, false};  ///< of each run by itself
constexpr SlowWanted kAllSlowParts{true, true, true, true, true, true, true};

/// `times` of the points from the first, s, where the platform's phase is `start_phase`; w = 0 where no
/// platform moves; shapes of parts with `wanted[part]` only.
SlowShapes slow_shapes(const std::vector<double>& times, double angular_frequency, double start_phase,
                       double reference_time, const SlowWanted& wanted);

/// U: the shapes in both axes behind the points' own whitening, `white` = the stack of L^-1 (LL' the points'
/// covariances, times the root of their weight), less what the unknown start point takes (the columns of
/// `white`). Column 2 j + k is shape j along the k-th of its axes.
Eigen::MatrixXd whitened_shapes(const SlowShapes& shapes, const Eigen::MatrixX2d& white);

/// (I + U G U')^(-1/2), G diagonal, through the eigenvalues l of G^(1/2) U'U G^(1/2) = R diag(l) R':
/// I - U G^(1/2) R diag((1 - (1 + l)^(-1/2)) / l) R' G^(1/2) U' (Woodbury's identity for a root).
class SlowWhitening {
 public:
  SlowWhitening() = default;
  /// U = `shapes`, whitened by the rest of the covariance, and the diagonal of G.
  SlowWhitening(Eigen::MatrixXd shapes, const Eigen::VectorXd& variances);

  bool empty() const { return shapes_.cols() == 0; }
  /// In place; columns that are zero stay so.
  void apply(Eigen::Ref<Eigen::VectorXd> column) const;
  /// What the points are expected to err by slowly, given `column` (white whitening alone): U G U' V^-1
  /// column, whitened like it.
  Eigen::VectorXd expected(const Eigen::VectorXd& column) const;
  /// The coefficients of the shapes expected, G U' V^-1 column, given V^(-1/2) column.
  Eigen::VectorXd coefficients(const Eigen::VectorXd& whitened) const;
  /// How many rows that takes out: sum of l/(1 + l).
  double rows_taken() const { return rows_taken_; }

 private:
  Eigen::MatrixXd shapes_;           ///< U G^(1/2) R
  Eigen::MatrixXd turned_;           ///< G^(1/2) R
  Eigen::VectorXd root_, expected_;  ///< (1 - (1 + l)^(-1/2)) / l and 1/(1 + l)
  double rows_taken_ = 0;
};

/// Of the shapes' columns in whitened_shapes().
Eigen::VectorXd column_variances(const SlowShapes& shapes, const SlowVariances& variances);

}  // namespace tribotrack::fit::internal
