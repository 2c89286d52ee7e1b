// Correlated errors: those that many points of one track share.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "fit/residuals/point_whitening.h"

namespace tribotrack::fit::internal {

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

}  // namespace tribotrack::fit::internal
