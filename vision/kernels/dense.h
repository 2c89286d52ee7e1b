// Decompositions of matrices, compiled here once: Eigen's take seconds in every source that instantiates
// them.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace tribotrack::vision {

/// As many unknowns as a registration turns out to have, at most kMost: no memory is allocated.
template <int kMost>
using FewByFew = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMost, kMost>;
template <int kMost>
using Few = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMost, 1>;

/// L D L^T of a symmetric matrix.
template <int kMost>
class FewFactor {
 public:
  explicit FewFactor(const FewByFew<kMost>& symmetric);
  void compute(const FewByFew<kMost>& symmetric);
  Few<kMost> solve(const Few<kMost>& right) const;
  FewByFew<kMost> solve(const FewByFew<kMost>& right) const;

 private:
  Eigen::LDLT<FewByFew<kMost>> factor_;
};

template <int kMost>
FewByFew<kMost> inverse_of(const FewByFew<kMost>& matrix);

extern template class FewFactor<5>;
extern template class FewFactor<8>;
extern template FewByFew<5> inverse_of(const FewByFew<5>&);
extern template FewByFew<8> inverse_of(const FewByFew<8>&);

Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& matrix);

/// Of a symmetric, positive definite matrix; also the logarithm of its determinant.
Eigen::MatrixXd inverse_of_spd(const Eigen::MatrixXd& matrix, double& log_determinant);

/// x of a x = b, a symmetric and positive definite, by L D L^T.
Eigen::MatrixXd solve_spd(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Of a symmetric matrix, ascending.
Eigen::Vector2d eigenvalues(const Eigen::Matrix2d& symmetric);
/// Its power -1/2.
Eigen::Matrix2d inverse_root(const Eigen::Matrix2d& symmetric);

}  // namespace tribotrack::vision
