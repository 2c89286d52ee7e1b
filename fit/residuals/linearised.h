// Whitened residuals and their Jacobian at one point, group by group.
//
// A row depends on the unknowns that all runs share and on those of its own runs,
//   r_g + S_g ds + O_g do_g,
// so that J'J is an arrow: the unknowns of different groups meet in the shared ones only. Eliminating each
// group's own (Schur's complement; here by projecting r_g and S_g off the columns of O_g, which keeps the
// digits that normal equations lose) leaves a problem of the few shared unknowns. Nothing grows faster than
// the number of runs.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace tribotrack::fit::internal {

struct RowGroup {
  Eigen::VectorXd residuals;
  Eigen::MatrixXd shared, own;  ///< derivatives; no columns where none were asked for
  Eigen::Index first_own = 0;   ///< place of the own ones in the vector of all unknowns
};

/// The shared unknowns come first in the vector of all.
struct Linearised {
  std::vector<RowGroup> groups;

  bool empty() const { return groups.empty(); }
  double chi2() const;
  bool finite() const;
  /// |J step|^2.
  double squared(const Eigen::VectorXd& step) const;
  /// J diag(units) for J.
  Linearised scaled(const Eigen::VectorXd& units) const;
  /// The own unknowns eliminated: what is left of residuals and shared columns, whatever those are.
  Linearised eliminated() const;
  /// J'J and J'r of the shared columns alone.
  Eigen::MatrixXd normal() const;
  Eigen::VectorXd gradient() const;
  /// The triangle of the QR decomposition of the shared columns.
  Eigen::MatrixXd triangle() const;
  /// All unknowns as they follow the shared ones by least squares of J step.
  Eigen::VectorXd following(const Eigen::VectorXd& shared_step, Eigen::Index unknowns) const;
  /// All rows and columns: small problems, and references.
  Eigen::VectorXd residuals() const;
  Eigen::MatrixXd jacobian(Eigen::Index unknowns) const;
};

/// By how much chi^2 would fall if the model were linear, r'J (J'J)^-1 J'r, directions the data do not see
/// left out. `held`: a shared unknown that stays.
double newton_decrement(const Linearised& at, std::optional<Eigen::Index> held = std::nullopt);

/// The pseudo-inverse of the shared unknowns' information, directions weaker than `flat` left out; `at` with
/// or without own unknowns.
Eigen::MatrixXd shared_covariance(const Linearised& at, double flat);

}  // namespace tribotrack::fit::internal
