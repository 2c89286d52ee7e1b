// One descent with Ceres; the unknowns of single runs are eliminated by Schur's complement.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

struct Minimum {
  Eigen::VectorXd z;
  double chi2 = 0;
  bool converged = false;
  bool joined = false;     ///< stopped because it entered the basin of a known minimum
  bool abandoned = false;  ///< stopped because it crawls far above a known minimum
  int descents = 1;        ///< that ended in it
  Linearised at;           ///< at z, as the descent saw it last; empty where the model has no motion
  /// Of another z, (z - this)' J'J (z - this): how much higher chi^2 would be there if the model were linear.
  double distance(const Unknowns& unknowns, const Eigen::VectorXd& other) const;
};

struct MinimiseOptions {
  /// This z, of what all runs share, stays as it is (profiles).
  std::optional<Eigen::Index> held = std::nullopt;
  /// Newton's decrement at which to stop: by how much chi^2 would still fall if the model were linear. 1e-10
  /// is 1e-5 standard deviations from the minimum.
  double decrement = 1e-10;
  int max_iterations = 100;
  bool patient = true;  ///< at a kink of chi^2: 8 steps that gain less than 1e-4 end it, else 4 of 0.01
  int full_steps = 40;  ///< in the full model at most (minimise_linearised)
  const std::vector<Minimum>* known = nullptr;
};

/// Levenberg-Marquardt, one thread, no bounds: the z axes have none. The linear solver is DENSE_SCHUR over
/// the unknowns of single runs, DENSE_QR where there are none (rank-deficient steps are damped). Derivatives
/// are the model's; every point is evaluated once, derivatives and all.
Minimum minimise(const Residuals& residuals, const Eigen::VectorXd& start,
                 const MinimiseOptions& options = {});

/// Of residuals that are linear in the conditions: the minimum of the full model by Levenberg and Marquardt's
/// method, the residuals linearised at every point; they are left linearised where it ends. Along a kink of
/// chi^2 it ends where no step leads down any more. The lag ends in (-pi, pi]. chi^2 is infinite where there
/// is no motion at `z`.
Minimum minimise_linearised(Residuals& residuals, const Eigen::VectorXd& z,
                            const MinimiseOptions& options = {});

/// With Minimum::at, where it has none.
Minimum linearised(const Residuals& residuals, Minimum minimum);

}  // namespace tribotrack::fit::internal
