#include "fit/uncertainty/covariance.h"

#include "fit/tools/dense.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kFlat = 1e-9;

struct Pseudo {
  Eigen::VectorXd singular_values;
  Eigen::MatrixXd directions;
  Eigen::Index rank;
  Eigen::MatrixXd inverse;  ///< of S'S
};

Pseudo pseudo_inverse(const Eigen::MatrixXd& sensitivity) {
  Pseudo result;
  const Eigen::Index n = sensitivity.cols();
  // The triangle of a QR decomposition has the same singular values and directions at a fraction of the cost.
  const SingularValues svd = singular_values(sensitivity.rows() > n ? triangle_of(sensitivity) : sensitivity);
  result.singular_values = Eigen::VectorXd::Zero(n);
  result.singular_values.head(svd.values.size()) = svd.values;
  result.directions = svd.directions;
  const double strongest = n > 0 ? result.singular_values(0) : 0;
  result.rank = (result.singular_values.array() > kFlat * strongest).count();
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(n);
  for (Eigen::Index k = 0; k < result.rank; ++k) squares(k) = std::pow(result.singular_values(k), -2);
  result.inverse = result.directions * squares.asDiagonal() * result.directions.transpose();
  return result;
}

}  // namespace

Uncertainty uncertainty(const Unknowns& unknowns, const Eigen::VectorXd& values,
                        const Eigen::MatrixXd& jacobian) {
  const Eigen::VectorXd units = unknowns.natural_units(values);
  const Eigen::MatrixXd sensitivity = jacobian * units.asDiagonal();
  const Eigen::Index n = unknowns.reported(), nuisances = unknowns.size() - n;

  Uncertainty result;
  result.units = units.head(n);
  result.column_norms = sensitivity.leftCols(n).colwise().norm();
  Eigen::MatrixXd own = sensitivity.leftCols(n);
  if (nuisances > 0) {
    // What the nuisances can imitate is no information.
    const Eigen::MatrixXd q = orthonormal_basis(sensitivity.rightCols(nuisances));
    own -= q * (q.transpose() * own).eval();
  }
  const Pseudo reported = pseudo_inverse(own);
  result.singular_values = reported.singular_values;
  result.directions = reported.directions;
  result.rank = reported.rank;
  result.covariance = result.units.asDiagonal() * reported.inverse * result.units.asDiagonal();
  result.full_covariance = units.asDiagonal() * pseudo_inverse(sensitivity).inverse * units.asDiagonal();
  return result;
}

}  // namespace tribotrack::fit::internal
