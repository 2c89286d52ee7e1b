// Conditions and laws of friction as linear terms of a displacement.
//
// What is known to an sd moves a displacement little, and what another law of friction adds is too slow to
// integrate in every step of a fit. Both enter linearly, theta being what is fitted:
//   x(theta, c) = x(theta, c_0) + D + D' (theta - theta_0) + sum_k C_k (c_k - c_0k),
// C_k the derivatives by condition k - exact, or differences of an integration under the law - at (theta_0,
// c_0), D what the laws at c_0 add there and D' its derivative: by mu1 and mu2 differences of integrations,
// and by the lag, as the drift turns with the pulses, J D on a platform that circles. A search descends in
// this; from where it ends every step is linearised anew (minimise_linearised): x, its derivatives, and with
// them the minimum are those of the full model.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fit/residuals/unknowns.h"

namespace tribotrack::fit::internal {

/// A summary run's displacement, and its derivatives by the unknowns that all runs share.
struct ModelledDisplacement {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m, in the picture (divided by the scale)
  Eigen::Matrix2Xd jacobian;                           ///< of those asked for; the others are 0
  Eigen::Matrix2d by_mu = Eigen::Matrix2d::Zero();  ///< by the run's mu1 and mu2, where these are asked for
};

class LinearTerms {
 public:
  /// Linearised at `values`: of the conditions among the unknowns; nullopt where the laws have no motion
  /// there.
  static std::optional<LinearTerms> at(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                       double tolerance, int threads);

  /// (theta_0, c_0).
  const Eigen::VectorXd& values() const { return values_; }
  /// At values(), by all unknowns.
  const ModelledDisplacement& here(std::size_t run) const { return runs_[run].here; }
  /// Values with conditions at c_0.
  Eigen::VectorXd held(Eigen::VectorXd values) const;
  /// Of the displacement by the paper's law, with conditions held, that of all: D and what is linear is
  /// added, and the derivatives by the conditions put in place of whatever their columns hold.
  void add(std::size_t run, const Eigen::VectorXd& values, ModelledDisplacement& by_paper) const;
  /// To the points of a trajectory run by the paper's law, and to their derivatives unless these are empty.
  void add(std::size_t run, const Eigen::VectorXd& values, Eigen::Matrix2Xd& positions,
           Eigen::MatrixXd& jacobian) const;

 private:
  struct Run {
    ModelledDisplacement here;
    Eigen::Vector2d by_laws = Eigen::Vector2d::Zero();  ///< D
    Eigen::Matrix2Xd bend;                              ///< D', by all unknowns but the laws
  };
  /// What laws add to a track: its own motion follows the paper's law and is not linear in anything.
  struct Track {
    std::vector<Eigen::Index> laws;
    Eigen::VectorXd added;          ///< D, m, x and y of each point below each other
    Eigen::MatrixXd by_laws, bend;  ///< C of the laws, and D' by what all runs share and the run's own
    Range own;
  };

  std::vector<Eigen::Index> linear_;  ///< conditions, among the unknowns
  std::vector<Eigen::Index> bent_;    ///< the other shared ones
  Eigen::VectorXd values_;
  std::vector<Run> runs_;
  std::vector<Track> tracks_;
};

/// By the paper's law, with derivatives by `by`.
ModelledDisplacement modelled_displacement(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                           const SummaryRun& run, const std::vector<Eigen::Index>& by,
                                           double tolerance);

/// Whether any displacement is linear in something, or any track in a law of friction.
bool has_linear_terms(const Unknowns& unknowns);

/// What summary runs are linear in: the conditions, but for the phase at the start, which may be anything,
/// and the scale: friction goes with it exactly where A was seen at it, and a line along it would be
/// information. The shared unknowns that are, or are not.
std::vector<Eigen::Index> linear_unknowns(const Unknowns& unknowns, bool linear);

}  // namespace tribotrack::fit::internal
