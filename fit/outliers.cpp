#include "fit/internal/outliers.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fit/internal/display.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kChance = 0.01;

/// P of `drop` in chi^2 by leaving out two data, when the rest has `rest` at `dof` degrees of freedom.
double chance(double drop, double rest, double dof) {
  if (dof < 1 || rest <= dof) return std::exp(-0.5 * drop);  // chi^2 with 2 degrees of freedom
  return std::pow(1 + drop / rest, -0.5 * dof);              // F with 2 and dof
}

/// The angle by which the run's pulse would have to be turned, where that explains its displacement.
std::optional<double> looks_like(const SummaryRun& run, const Eigen::Vector2d& modelled, double sigma) {
  const Eigen::Vector2d& measured = run.measured.vector;
  if (std::abs(measured.norm() - modelled.norm()) > 4 * sigma + 0.1 * modelled.norm()) return std::nullopt;
  double turned = std::atan2(measured.y(), measured.x()) - std::atan2(modelled.y(), modelled.x());
  if (std::sin(run.scenario.drive.phase_shift) >= 0) turned = -turned;  // clockwise
  return std::remainder(run.scenario.friction.phase + turned, 2 * std::numbers::pi);
}

}  // namespace

std::vector<Outlier> find_outliers(const Residuals& residuals, const Minimum& best,
                                   const Eigen::MatrixXd& full_covariance) {
  const Problem& problem = residuals.unknowns().problem();
  const std::size_t runs = problem.summary_runs.size();
  const double chi2 = best.residuals.squaredNorm(), dof = residuals.degrees_of_freedom();
  std::vector<Outlier> found;
  for (std::size_t i = 0; i < runs; ++i) {
    const auto row = 2 * static_cast<Eigen::Index>(i);
    const double root = std::sqrt(residuals.run_weight(i));
    const Eigen::Vector2d r = best.residuals.segment<2>(row) / root;
    const Eigen::MatrixXd j = best.jacobian.middleRows(row, 2) / root;
    const Eigen::Matrix2d left =
        Eigen::Matrix2d::Identity() - root * root * j * full_covariance * j.transpose();
    if (!(left.determinant() > 1e-9)) continue;  // the run alone pins something: nothing checks it
    const double drop = r.dot(left.inverse() * r);
    Outlier outlier;
    outlier.run = problem.summary_runs[i].name;
    const double rest = std::max(0.0, chi2 - root * root * drop);
    outlier.chance = std::min(1.0, static_cast<double>(runs) * chance(drop, rest, dof - 2));
    if (!(outlier.chance < kChance)) continue;
    const double spread = rest > dof - 2 && dof > 2 ? std::sqrt(rest / (dof - 2)) : 1;
    outlier.deviation = std::sqrt(drop) / spread;
    const Eigen::Vector2d modelled =
        problem.summary_runs[i].measured.vector - residuals.difference(best.residuals, i);
    const auto phi =
        looks_like(problem.summary_runs[i], modelled, std::sqrt(0.5 * residuals.covariance(i).trace()));
    outlier.sentence = "Run '" + outlier.run + "' lies " + number(outlier.deviation, 2) +
                       " sigma from what all other runs say (chance " + number(outlier.chance, 1) +
                       "); check its phi, dtau and label";
    if (phi) {
      outlier.looks_like_phi = *phi < 0 ? *phi + 2 * std::numbers::pi : *phi;
      outlier.sentence += ": it moved as if phi were " +
                          number(*outlier.looks_like_phi / std::numbers::pi, 2) + " pi instead of " +
                          number(problem.summary_runs[i].scenario.friction.phase / std::numbers::pi, 2) +
                          " pi";
    }
    outlier.sentence += ".";
    found.push_back(outlier);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Outlier& a, const Outlier& b) { return a.deviation > b.deviation; });
  return found;
}

}  // namespace tribotrack::fit::internal
