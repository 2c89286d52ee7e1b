#include "vision/kernels/dense.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace tribotrack::vision {

template <int kMost>
FewFactor<kMost>::FewFactor(const FewByFew<kMost>& symmetric) : factor_(symmetric) {}

template <int kMost>
void FewFactor<kMost>::compute(const FewByFew<kMost>& symmetric) {
  factor_.compute(symmetric);
}

template <int kMost>
Few<kMost> FewFactor<kMost>::solve(const Few<kMost>& right) const {
  return factor_.solve(right);
}

template <int kMost>
FewByFew<kMost> FewFactor<kMost>::solve(const FewByFew<kMost>& right) const {
  return factor_.solve(right);
}

template <int kMost>
FewByFew<kMost> inverse_of(const FewByFew<kMost>& matrix) {
  return matrix.inverse();
}

template class FewFactor<5>;
template class FewFactor<8>;
template FewByFew<5> inverse_of(const FewByFew<5>&);
template FewByFew<8> inverse_of(const FewByFew<8>&);

Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& matrix) {
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
