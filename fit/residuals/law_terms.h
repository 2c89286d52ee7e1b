// What another law of friction adds to the motion of each run. Its integration is too slow for a fit and has
// no derivatives, but its strengths are small and few:
//   x(theta, s) = x(theta, 0) + D(s_0) + sum_k C_k (s_k - s_0k),   D = x(theta_0, s_0) - x(theta_0, 0),
// the columns C_k by differences at (theta_0, s_0). Where a descent ends it is done again, until it stays.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fit/residuals/unknowns.h"

namespace tribotrack::fit::internal {

/// The unknowns that are laws, and what they add to the positions of a run, in the picture.
class LawTerms {
 public:
  /// Linearised at `values`; nullopt where the laws have no motion there. `times`: of the points of each
  /// trajectory run.
  static std::optional<LawTerms> at(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                    const std::vector<const std::vector<double>*>& times, int threads);

  /// m. Summary runs have one position, then come the trajectory runs.
  Eigen::Matrix2Xd added(std::size_t run, const Eigen::VectorXd& values) const;
  /// Adds d added / d unknowns to `columns`, two rows a position, whose first columns are those of the shared
  /// unknowns.
  void add_derivatives(std::size_t run, Eigen::Ref<Eigen::MatrixXd> columns) const;

 private:
  struct Run {
    Eigen::Matrix2Xd there;                 ///< D
    std::vector<Eigen::Matrix2Xd> columns;  ///< C_k
  };
  std::vector<Eigen::Index> unknowns_;
  Eigen::VectorXd at_;
  std::vector<Run> runs_;
};

/// Unknowns among kLaws.
std::vector<Eigen::Index> unknown_laws(const Unknowns& unknowns);

}  // namespace tribotrack::fit::internal
