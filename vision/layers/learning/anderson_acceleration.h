// Faster convergence of alternating estimates.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace tribotrack::vision {

/// Anderson acceleration of x = g(x) (Walker and Ni, SIAM J. Numer. Anal. 49, 2011): the next x is the
/// combination of the last images g(x_k) whose residual g(x_k) - x_k is least. A slow mode of plain
/// iteration, which shrinks by a few percent each time, is gone in a few steps. Forgets its past where the
/// residual has grown.
class AndersonAcceleration {
 public:
  explicit AndersonAcceleration(std::size_t depth = 5) : depth_(depth) {}
  /// From x and g(x) to the x to try next.
  Eigen::VectorXd next(const Eigen::VectorXd& from, const Eigen::VectorXd& to);

 private:
  std::size_t depth_;
  Eigen::VectorXd last_to_, last_residual_;
  std::vector<Eigen::VectorXd> images_, residuals_;  ///< differences of successive ones
};

}  // namespace tribotrack::vision
