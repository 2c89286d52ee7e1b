// A textbook Levenberg-Marquardt for three parameters: what a researcher writes around a solver.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <functional>

namespace tribotrack::bench {

struct PlainDescent {
  Eigen::Vector3d z = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< (J'J)^-1
  double chi2 = 0;
  bool converged = false;
};

/// Residuals at z; the Jacobian where it is not null.
using PlainResiduals = std::function<Eigen::VectorXd(const Eigen::Vector3d& z, Eigen::MatrixX3d* jacobian)>;

/// Ends when a step changes no parameter by more than 1e-7 or chi-square by less than 1e-10 of it, without
/// convergence after max_iterations or when no step helps.
inline PlainDescent descend(const PlainResiduals& residuals, const Eigen::Vector3d& start,
                            int max_iterations) {
  PlainDescent state;
  state.z = start;
  Eigen::MatrixX3d j;
  Eigen::VectorXd r = residuals(state.z, &j);
  state.chi2 = r.squaredNorm();
  double damping = 1e-3;
  for (int iteration = 0; iteration < max_iterations && !state.converged && damping < 1e12; ++iteration) {
    const Eigen::Matrix3d normal = j.transpose() * j;
    Eigen::Matrix3d damped = normal;
    damped.diagonal() += damping * normal.diagonal();
    const Eigen::Vector3d step = -damped.ldlt().solve(j.transpose() * r);
    const Eigen::Vector3d trial = state.z + step;
    const double chi2 = residuals(trial, nullptr).squaredNorm();
    if (!(chi2 <= state.chi2)) {
      damping *= 10;
      // A step this small that still does not help: the minimum, as far as these derivatives see it.
      state.converged = step.cwiseAbs().maxCoeff() < 1e-7;
      continue;
    }
    const bool settled = step.cwiseAbs().maxCoeff() < 1e-7 || state.chi2 - chi2 <= 1e-10 * chi2;
    state.z = trial;
    state.chi2 = chi2;
    damping *= 0.1;
    r = residuals(state.z, &j);
    state.converged = settled;
  }
  state.covariance = (j.transpose() * j).inverse();
  return state;
}

}  // namespace tribotrack::bench
