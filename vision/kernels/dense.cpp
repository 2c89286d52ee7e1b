#include "vision/kernels/dense.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace tribotrack::vision {

FewFactor::FewFactor(const FewByFew& symmetric) : factor_(symmetric) {}

void FewFactor::compute(const FewByFew& symmetric) {
  factor_.compute(symmetric);
}

Few FewFactor::solve(const Few& right) const {
  return factor_.solve(right);
}

FewByFew FewFactor::solve(const FewByFew& right) const {
  return factor_.solve(right);
}

FewByFew inverse_of(const FewByFew& matrix) {
  return matrix.inverse();
}

Eigen::MatrixXd inverse_of_spd(const Eigen::MatrixXd& matrix, double& log_determinant) {
  const Eigen::LLT<Eigen::MatrixXd> root(matrix);
  log_determinant = 2 * root.matrixLLT().diagonal().array().log().sum();
  return root.solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
}

Eigen::MatrixXd solve_spd(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.ldlt().solve(b);
}

Eigen::Vector2d eigenvalues(const Eigen::Matrix2d& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(symmetric).eigenvalues();
}

Eigen::Matrix2d inverse_root(const Eigen::Matrix2d& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(symmetric).operatorInverseSqrt();
}

}  // namespace tribotrack::vision
