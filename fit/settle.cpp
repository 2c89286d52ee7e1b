#include "fit/internal/settle.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "fit/internal/robust.h"
#include "fit/internal/scatter.h"

namespace tribotrack::fit::internal {
namespace {

constexpr int kRounds = 12;

/// The same evaluation under other weights, without simulating again: summary rows only differ by factors.
bool reweigh(Minimum& at, const Residuals& before, const Residuals& now) {
  const Problem& problem = now.unknowns().problem();
  if (!problem.trajectory_runs.empty() || at.jacobian.rows() == 0) return false;
  for (std::size_t i = 0; i < problem.summary_runs.size(); ++i) {
    const auto row = 2 * static_cast<Eigen::Index>(i);
    const Eigen::LLT<Eigen::Matrix2d> old_factor(before.covariance(i)), new_factor(now.covariance(i));
    const double root = std::sqrt(now.run_weight(i) / before.run_weight(i));
    const Eigen::Matrix2d old_root = old_factor.matrixL();
    const Eigen::Matrix2d factor = root * new_factor.matrixL().solve(old_root);
    at.residuals.segment<2>(row) = (factor * at.residuals.segment<2>(row)).eval();
    at.jacobian.middleRows(row, 2) = (factor * at.jacobian.middleRows(row, 2)).eval();
  }
  at.chi2 = at.residuals.squaredNorm();
  return true;
}

double largest_change(const Weights& a, const Weights& b) {
  double change = 0;
  for (std::size_t i = 0; i < a.runs.size(); ++i)
    change = std::max(change, std::abs(a.runs[i] - (b.runs.empty() ? 1 : b.runs[i])));
  return change;
}

}  // namespace

bool any(const Scatter& scatter) {
  return scatter.runs() > 0 || std::any_of(scatter.trajectories.begin(), scatter.trajectories.end(),
                                           [](const auto& run) { return run.between_points > 0; });
}

void settle(Residuals& residuals, Minimum& best, bool with_scatter, Loss loss) {
  const Unknowns& unknowns = residuals.unknowns();
  for (int round = 0; round < kRounds; ++round) {
    const Residuals before = residuals;
    if (best.jacobian.rows() == 0) best = with_curvature(residuals, best).minimum;
    const Eigen::VectorXd values = unknowns.values(best.z);
    if (with_scatter)
      residuals.set_scatter(loss == Loss::squares ? estimate_scatter(residuals, values, best.residuals)
                                                  : robust_scatter(residuals, values, best.residuals));
    if (loss != Loss::squares) residuals.set_weights(robust_weights(residuals, values, best.residuals, loss));
    if (loss == Loss::squares && !any(residuals.scatter())) return;
    const double change = largest_change(residuals.weights(), before.weights());
    const Scatter &was = before.scatter(), &is = residuals.scatter();
    MinimiseOptions options;
    if (reweigh(best, before, residuals)) options.evaluated = &best;
    best = minimise(residuals, best.z, options);
    if (round > 1 && change < 1e-3 && std::abs(is.along - was.along) <= 1e-3 * was.along &&
        std::abs(is.across - was.across) <= 1e-3 * was.across)
      return;
  }
}

}  // namespace tribotrack::fit::internal
