// Decompositions of dense matrices. Those of a size known at run time only are compiled once, here: each of
// their templates costs seconds in every source that names it.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace tribotrack::fit::internal {

/// Cholesky's factor L of a covariance of two coordinates, C = L L'.
class Factor2 {
 public:
  explicit Factor2(const Eigen::Matrix2d& c) : llt_(c) {}
  bool positive() const { return llt_.info() == Eigen::Success; }  ///< else there is no L
  Eigen::Matrix2d lower() const { return llt_.matrixL(); }
  Eigen::Matrix2d inverse_lower() const { return llt_.matrixL().solve(Eigen::Matrix2d::Identity()); }
  Eigen::Vector2d whitened(const Eigen::Vector2d& v) const { return llt_.matrixL().solve(v); }  ///< L^-1 v
  Eigen::Vector2d solved(const Eigen::Vector2d& v) const { return llt_.solve(v); }              ///< C^-1 v
  Eigen::Matrix2Xd whiten_columns(const Eigen::Matrix2Xd& columns) const {                      ///< L^-1 B
    return llt_.matrixL().solve(columns);
  }
  Eigen::Matrix2Xd by_upper(const Eigen::Matrix2Xd& columns) const {  ///< L'^-1 B
    return llt_.matrixU().solve(columns);
  }

 private:
  Eigen::LLT<Eigen::Matrix2d> llt_;
};

/// Cholesky's factor L of a symmetric matrix, A = L L'.
class Factor {
 public:
  explicit Factor(const Eigen::MatrixXd& matrix);
  bool positive() const { return positive_; }
  const Eigen::MatrixXd& lower() const { return lower_; }
  double log_determinant_of_root() const { return lower_.diagonal().array().log().sum(); }
  Eigen::MatrixXd whitened(const Eigen::MatrixXd& columns) const;  ///< L^-1 B

 private:
  Eigen::MatrixXd lower_;
  bool positive_ = false;
};

/// A^-1 b and A^-1 of a symmetric A that is not negative, by LDL' with pivots.
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::Matrix2Xd solve_symmetric2(const Eigen::Matrix2d& a, const Eigen::Matrix2Xd& b);
Eigen::MatrixXd inverse_symmetric(const Eigen::MatrixXd& a);

/// Eigenvalues of a symmetric matrix, the least first, and its eigenvectors.
struct EigenSystem {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
EigenSystem eigen_symmetric(const Eigen::MatrixXd& matrix);
Eigen::Vector2d eigenvalues(const Eigen::Matrix2d& symmetric);  ///< the least first
Eigen::Matrix2d without_negative_eigenvalues(const Eigen::Matrix2d& symmetric);

/// The inverse of a symmetric matrix that is not negative, and ln of its determinant, but for directions
/// weaker than `flat` where rows and columns are multiplied by `scale`.
struct PseudoInverse {
  Eigen::MatrixXd inverse;
  double log_determinant = 0;
  Eigen::Index rank = 0;
};
PseudoInverse pseudo_inverse(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& scale, double flat);
/// By which the diagonal becomes 1.
Eigen::VectorXd unit_diagonal(const Eigen::MatrixXd& matrix);

/// Singular values, the greatest first, and directions: A = U diag(values) directions'.
struct SingularValues {
  Eigen::VectorXd values;
  Eigen::MatrixXd directions;
};
SingularValues singular_values(const Eigen::MatrixXd& matrix);

/// R of A = Q R, its rows as many as A has, or columns where those are fewer.
Eigen::MatrixXd triangle_of(Eigen::MatrixXd matrix);

/// An orthonormal basis of the columns; of two that are independent, and of what remains of any by rank.
Eigen::MatrixX2d orthonormal(const Eigen::MatrixX2d& columns);
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& columns);

/// x of the least |A x - b|; where many are alike, the shortest.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

}  // namespace tribotrack::fit::internal
