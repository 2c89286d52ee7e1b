#include "fit/variances/correlated_variances.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "fit/tools/dense.h"
#include "fit/variances/correlated_likelihood.h"

namespace tribotrack::fit::internal {
namespace {

/// Of twice the log-likelihood. The parts stand or fall together: one left out by a test is one taken as
/// exactly 0, and intervals after it are too short wherever it nearly passed (a drift beside a walk, which
/// explains most of a line, hardly ever does). By chance all four gain as much in 2 % of campaigns
/// (chi-bar-squared: half of them are 0 by chance).
constexpr double kLeastGain = 8.5;
constexpr int kRounds = 60;
constexpr double kArrived = 1e-3;  ///< of the log-likelihood

struct Place {
  PartNumbers variances;
  CorrelatedLikelihood likelihood;
};

/// Fisher's scoring, no part below 0.
Place most_likely(const CorrelatedSums& sums, const PartNumbers& variances) {
  Place here{variances, correlated_likelihood_at(sums, variances)};
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Eigen::Index> moving;
    for (Eigen::Index g = 0; g < variances.size(); ++g)
      if (here.variances(g) > 0 || here.likelihood.slope(g) > 0) moving.push_back(g);
    if (moving.empty()) break;
    const Eigen::MatrixXd information = here.likelihood.information(moving, moving);
    const Eigen::VectorXd slope = here.likelihood.slope(moving), step = solve_symmetric(information, slope);
    if (!step.allFinite() || 0.5 * slope.dot(step) < kArrived) break;
    bool moved = false;
    for (double share = 1; share > 1e-3 && !moved; share /= 2) {
      Place there{here.variances, {}};
      for (std::size_t k = 0; k < moving.size(); ++k) {
        double& variance = there.variances(moving[k]);
        variance = std::max(0.0, variance + share * step(static_cast<Eigen::Index>(k)));
      }
      there.likelihood = correlated_likelihood_at(sums, there.variances);
      if (!(there.likelihood.log > here.likelihood.log)) continue;
      moved = there.likelihood.log - here.likelihood.log > kArrived;
      here = std::move(there);
    }
    if (!moved) break;
  }
  return here;
}

}  // namespace

CorrelatedEstimate estimate_correlated_errors(const Residuals& residuals, const Eigen::VectorXd& values) {
  CorrelatedEstimate result;
  result.degrees_of_freedom =
      Eigen::VectorXd::Constant(residuals.unknowns().common(), std::numeric_limits<double>::infinity());
  const CorrelatedSums sums = correlated_sums_of(residuals, values);
  if (sums.runs.empty()) return result;

  const PartNumbers guess = Eigen::Map<const PartNumbers>(residuals.excess_variance().correlated.data());
  const Place place = most_likely(sums, guess.cwiseQuotient(sums.unit));
  const double none = correlated_likelihood_at(sums, PartNumbers::Zero()).log;
  if (2 * (place.likelihood.log - none) < kLeastGain) return result;

  const PartNumbers& best = place.variances;
  const CorrelatedLikelihood& at = place.likelihood;
  std::vector<Eigen::Index> present;
  for (Eigen::Index g = 0; g < best.size(); ++g)
    if (best(g) > 0) present.push_back(g);
  if (present.empty()) return result;
  const Eigen::MatrixXd information = at.information(present, present);
  const Eigen::MatrixXd spread = inverse_symmetric(information);
  for (std::size_t k = 0; k < present.size(); ++k) {
    const auto g = static_cast<std::size_t>(present[k]);
    const auto row = static_cast<Eigen::Index>(k);
    result.variances[g] = best(present[k]) * sums.unit(present[k]);
    result.sd[g] = std::sqrt(spread(row, row)) * sums.unit(present[k]);
  }
  for (Eigen::Index i = 0; i < result.degrees_of_freedom.size(); ++i) {
    Eigen::VectorXd slopes(static_cast<Eigen::Index>(present.size()));
    for (std::size_t k = 0; k < present.size(); ++k)
      slopes(static_cast<Eigen::Index>(k)) = at.by_variance[static_cast<std::size_t>(present[k])](i, i);
    const double variance = at.covariance(i, i), of_variance = slopes.dot(spread * slopes);
    if (of_variance > 0) result.degrees_of_freedom(i) = 2 * variance * variance / of_variance;
  }
  return result;
}

}  // namespace tribotrack::fit::internal
