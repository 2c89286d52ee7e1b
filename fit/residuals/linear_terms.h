// Conditions and laws of friction as linear terms of a displacement.
//
// What is known to an sd moves a displacement little, and what another law of friction adds is too slow to
// integrate in every step of a fit. Both enter linearly, theta being what is fitted:
//   x(theta, c) = x(theta, c_0) + D + sum_k C_k (c_k - c_0k),
// C_k the derivatives by condition k - exact, or differences of an integration under the law - at (theta_0,
// c_0), and D what the laws at c_0 add there. Where a descent ends it is linearised again, until it stays
// (minimise_linearised): then x, its derivatives, and with them the minimum are those of the full model.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fit/residuals/unknowns.h"

namespace tribotrack::fit::internal {

class LinearTerms {
 public:
  /// Linearised at `values`: of the conditions among the unknowns; nullopt where the laws have no motion
  /// there.
  static std::optional<LinearTerms> at(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                       double tolerance, int threads);

  /// Values with conditions at c_0.
  Eigen::VectorXd held(Eigen::VectorXd values) const;
  /// D + sum C_k (c_k - c_0k) of a summary run, m.
  Eigen::Vector2d added(std::size_t run, const Eigen::VectorXd& values) const;
  /// The derivatives by the conditions, in place of whatever their columns hold.
  void put_derivatives(std::size_t run, Eigen::Ref<Eigen::Matrix2Xd> by_unknowns) const;

 private:
  struct Run {
    Eigen::Vector2d by_laws = Eigen::Vector2d::Zero();  ///< D
    Eigen::Matrix2Xd columns;                           ///< C
  };
  std::vector<Eigen::Index> linear_;  ///< conditions, among the unknowns
  Eigen::VectorXd at_;                ///< c_0
  std::vector<Run> runs_;
};

/// A summary run's displacement, and its derivatives by the unknowns that all runs share.
struct ModelledDisplacement {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m, in the picture (divided by the scale)
  Eigen::Matrix2Xd jacobian;                           ///< of those asked for; the others are 0
};

/// By the paper's law, with derivatives by `by`.
ModelledDisplacement modelled_displacement(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                           const SummaryRun& run, const std::vector<Eigen::Index>& by,
                                           double tolerance);

/// What summary runs are linear in: the conditions, but for the phase at the start, which may be anything,
/// and the scale: friction goes with it exactly where A was seen at it, and a line along it would be
/// information.
bool is_linear(const Unknowns& unknowns, Eigen::Index unknown);
/// The shared unknowns that are, or are not.
std::vector<Eigen::Index> linear_unknowns(const Unknowns& unknowns, bool linear);

}  // namespace tribotrack::fit::internal
