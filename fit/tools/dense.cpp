#include "fit/tools/dense.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace tribotrack::fit::internal {

Factor::Factor(const Eigen::MatrixXd& matrix) {
  const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
  positive_ = factor.info() == Eigen::Success;
  lower_ = factor.matrixL();
}

Eigen::MatrixXd Factor::whitened(const Eigen::MatrixXd& columns) const {
  return lower_.triangularView<Eigen::Lower>().solve(columns);
}

Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.ldlt().solve(b);
}

Eigen::Matrix2Xd solve_symmetric2(const Eigen::Matrix2d& a, const Eigen::Matrix2Xd& b) {
  return a.ldlt().solve(b);
}

Eigen::MatrixXd inverse_symmetric(const Eigen::MatrixXd& a) {
  return a.ldlt().solve(Eigen::MatrixXd::Identity(a.rows(), a.cols()));
}

EigenSystem eigen_symmetric(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

PseudoInverse pseudo_inverse(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& scale, double flat) {
  const EigenSystem eigen = eigen_symmetric(scale.asDiagonal() * matrix * scale.asDiagonal());
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(scale.size());
  double log_determinant = -2 * scale.array().log().sum();
  for (Eigen::Index i = 0; i < inverse.size(); ++i) {
    if (!(eigen.values(i) > flat)) continue;
    inverse(i) = 1 / eigen.values(i);
    log_determinant += std::log(eigen.values(i));
  }
  return {scale.asDiagonal() * eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose() *
              scale.asDiagonal(),
          log_determinant, (inverse.array() > 0).count()};
}

Eigen::VectorXd unit_diagonal(const Eigen::MatrixXd& matrix) {
  return matrix.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
}

Eigen::Vector2d eigenvalues(const Eigen::Matrix2d& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(symmetric, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::Matrix2d without_negative_eigenvalues(const Eigen::Matrix2d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(symmetric);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

SingularValues singular_values(const Eigen::MatrixXd& matrix) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(matrix, Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixV()};
}

Eigen::MatrixXd triangle_of(Eigen::MatrixXd matrix) {
  const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(matrix);
  return qr.matrixQR().topRows(std::min(matrix.rows(), matrix.cols())).triangularView<Eigen::Upper>();
}

Eigen::MatrixX2d orthonormal(const Eigen::MatrixX2d& columns) {
  Eigen::MatrixX2d q = columns;
  q.col(0).normalize();
  for (int twice = 0; twice < 2; ++twice)  // once leaves what rounding makes of columns nearly alike
    q.col(1) = (q.col(1) - q.col(0) * q.col(0).dot(q.col(1))).normalized();
  return q;
}

Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& columns) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), std::min(columns.rows(), qr.rank()));
}

Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

}  // namespace tribotrack::fit::internal
