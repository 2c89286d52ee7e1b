#include "fit/uncertainty/curved_residuals.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>

#include "fit/tools/parallel.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kLeastEigenvalue = 1e-10;  ///< least eigenvalue of the scaled normal matrix
constexpr int kMostSteps = 12;
constexpr double kArrived = 1e-4;  ///< standard deviations
constexpr double kFarthest = 8;    ///< beyond, second order is useless
/// Misfit of the second order at its minimum, in sigma for each standard deviation gone: its derivatives are
/// off by about three times as much.
constexpr double kMisfit = 0.006;
constexpr double kLastStep = 0.1;  ///< standard deviations

/// Columns v_j with v_j' C v_k = delta_jk; nothing where C has a flat direction.
std::optional<Eigen::MatrixXd> principal_axes(const Eigen::MatrixXd& curvature) {
  const Eigen::VectorXd scale = curvature.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * curvature *
                                                             scale.asDiagonal());
  if (eigen.info() != Eigen::Success || !(eigen.eigenvalues()(0) > kLeastEigenvalue)) return std::nullopt;
  return scale.asDiagonal() * eigen.eigenvectors() *
         eigen.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal();
}

}  // namespace

std::optional<CurvedResiduals> CurvedResiduals::about(const Residuals& residuals, const Minimum& best,
                                                      int threads) {
  const Unknowns& unknowns = residuals.unknowns();
  const Eigen::MatrixXd by_z = best.jacobian * unknowns.slopes(best.z).asDiagonal();
  const auto axes = principal_axes(by_z.transpose() * by_z);
  if (!axes) return std::nullopt;
  CurvedResiduals curved;
  curved.z_ = best.z;
  curved.axes_ = *axes;
  curved.jacobian_ = by_z * *axes;
  const auto n = static_cast<std::size_t>(axes->cols());
  std::vector<Eigen::MatrixXd> aside(2 * n);
  std::atomic<bool> known = true;
  parallel_for(aside.size(), threads, [&](std::size_t k) {
    const Eigen::VectorXd z = best.z + (k % 2 == 0 ? 1 : -1) * axes->col(static_cast<Eigen::Index>(k / 2));
    Eigen::VectorXd r;
    Eigen::MatrixXd jacobian;
    if (!residuals.evaluate(unknowns.values(z), r, &jacobian)) {
      known = false;
      return;
    }
    aside[k] = jacobian * unknowns.slopes(z).asDiagonal() * *axes;
  });
  if (!known) return std::nullopt;
  for (std::size_t j = 0; j < n; ++j) curved.second_.push_back(0.5 * (aside[2 * j] - aside[2 * j + 1]));
  // Mixed derivatives are symmetric.
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t k = 0; k < j; ++k) {
      const auto column = static_cast<Eigen::Index>(j), other = static_cast<Eigen::Index>(k);
      const Eigen::VectorXd mean = 0.5 * (curved.second_[j].col(other) + curved.second_[k].col(column));
      curved.second_[j].col(other) = curved.second_[k].col(column) = mean;
    }
  return curved;
}

Eigen::MatrixXd CurvedResiduals::jacobian(const Eigen::VectorXd& t) const {
  Eigen::MatrixXd sum = jacobian_;
  for (std::size_t j = 0; j < second_.size(); ++j) sum += t(static_cast<Eigen::Index>(j)) * second_[j];
  return sum;
}

Eigen::VectorXd CurvedResiduals::at(const Eigen::VectorXd& r0, const Eigen::VectorXd& t) const {
  return r0 + 0.5 * ((jacobian_ + jacobian(t)) * t);
}

Eigen::VectorXd CurvedResiduals::step(const Eigen::VectorXd& r, const Eigen::VectorXd& t) const {
  const Eigen::MatrixXd j = jacobian(t);
  return -(j.transpose() * j).ldlt().solve(j.transpose() * r);
}

std::optional<Eigen::VectorXd> CurvedResiduals::minimum(const Eigen::VectorXd& r0) const {
  Eigen::VectorXd t = Eigen::VectorXd::Zero(axes_.cols());
  for (int i = 0; i < kMostSteps; ++i) {
    const Eigen::VectorXd by = step(at(r0, t), t);
    t += by;
    if (!(t.norm() < kFarthest)) return std::nullopt;
    if (by.norm() < kArrived) return t;
  }
  return std::nullopt;
}

std::optional<Eigen::VectorXd> CurvedResiduals::confirmed(const Eigen::VectorXd& r0, const Eigen::VectorXd& t,
                                                          const Eigen::VectorXd& exact) const {
  const double misfit = (exact - at(r0, t)).norm();
  const Eigen::VectorXd last = step(exact, t);
  if (!(misfit < kMisfit * std::max(1.0, t.norm())) || !(last.norm() < kLastStep)) return std::nullopt;
  return t + last;
}

}  // namespace tribotrack::fit::internal
