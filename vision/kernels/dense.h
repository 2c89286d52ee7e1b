// Decompositions of matrices, compiled here once: Eigen's take seconds in every source that instantiates
// them.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

namespace tribotrack::vision {

/// As many unknowns as a registration turns out to have, eight at most: no memory is allocated.
using FewByFew = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 8, 8>;
using Few = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 8, 1>;

/// L D L^T of a symmetric matrix.
class FewFactor {
 public:
  explicit FewFactor(const FewByFew& symmetric);
  void compute(const FewByFew& symmetric);
  Few solve(const Few& right) const;
  FewByFew solve(const FewByFew& right) const;

 private:
  Eigen::LDLT<FewByFew> factor_;
};

FewByFew inverse_of(const FewByFew& matrix);

/// Of n rows, from its upper triangle, row after row.
FewByFew symmetric(const auto& upper, int n) {
  FewByFew matrix(n, n);
  for (int i = 0, k = 0; i < n; ++i)
    for (int j = i; j < n; ++j, ++k) matrix(i, j) = matrix(j, i) = upper[static_cast<std::size_t>(k)];
  return matrix;
}

/// Of a symmetric, positive definite matrix; also the logarithm of its determinant.
Eigen::MatrixXd inverse_of_spd(const Eigen::MatrixXd& matrix, double& log_determinant);

/// x of a x = b, a symmetric and positive definite, by L D L^T.
Eigen::MatrixXd solve_spd(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Of a symmetric matrix, ascending.
Eigen::Vector2d eigenvalues(const Eigen::Matrix2d& symmetric);
/// Its power -1/2.
Eigen::Matrix2d inverse_root(const Eigen::Matrix2d& symmetric);

// A point of a track states its errors as two standard deviations and their correlation.

Eigen::Matrix2d covariance_of(const auto& p) {
  const double off = p.rho_xy * p.sigma_x * p.sigma_y;
  return Eigen::Matrix2d{{p.sigma_x * p.sigma_x, off}, {off, p.sigma_y * p.sigma_y}};
}

void set_covariance(auto& p, const Eigen::Matrix2d& covariance) {
  p.sigma_x = std::sqrt(covariance(0, 0));
  p.sigma_y = std::sqrt(covariance(1, 1));
  p.rho_xy = covariance(0, 1) / (p.sigma_x * p.sigma_y);
}

}  // namespace tribotrack::vision
