#include "fit/variances/correlated_variances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "fit/tools/dense.h"

namespace tribotrack::fit::internal {
namespace {

/// A number for each part.
using PartNumbers = Eigen::Matrix<double, static_cast<int>(kErrorParts), 1>;
using PartSquare = Eigen::Matrix<double, static_cast<int>(kErrorParts), static_cast<int>(kErrorParts)>;

/// All that the likelihood needs of one run: U'U and U'[J r].
struct RunSums {
  Eigen::MatrixXd shapes, data;
  std::vector<std::size_t> part;  ///< of each column of U
};

struct Sums {
  std::vector<RunSums> runs;
  Eigen::MatrixXd data;  ///< [J r]'[J r] of all rows
  PartNumbers unit;      ///< m^2: the variance of each part at which it is as large as the white noise
};

/// Of the residuals at `values` and their Jacobian, whitened but for correlated errors; no runs where the
/// model fails.
Sums sums_of(const Residuals& residuals, const Eigen::VectorXd& values) {
  Residuals white = residuals;
  ExcessVariance scatter = residuals.excess_variance();
  scatter.correlated = {};
  white.set_excess_variance(scatter);
  Sums sums;
  const auto at = white.at(values);
  if (!at) return sums;
  const Unknowns& unknowns = residuals.unknowns();
  const Linearised rows = at->scaled(unknowns.natural_units(values)), left = rows.eliminated();
  // Unknowns of driven runs, whose rows the variances weigh anew, stay; those of slides are eliminated.
  const auto& runs = unknowns.problem().trajectory_runs;
  Eigen::Index width = unknowns.common() + 1;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (!runs[i].free_slide) width += unknowns.own(i).count;
  sums.data = Eigen::MatrixXd::Zero(width, width);
  std::vector<Eigen::MatrixXd> driven(runs.size());  // [J r] of each
  Eigen::Index next = unknowns.common();
  for (std::size_t g = 0; g < rows.groups.size(); ++g) {
    const bool stays = g > 0 && !runs[g - 1].free_slide;
    const RowGroup& group = stays ? rows.groups[g] : left.groups[g];
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(group.residuals.size(), width);
    all.leftCols(unknowns.common()) = group.shared;
    all.middleCols(next, group.own.cols()) = group.own;
    all.rightCols<1>() = group.residuals;
    sums.data += all.transpose() * all;
    if (!stays) continue;
    next += group.own.cols();
    driven[g - 1] = std::move(all);
  }
  PartNumbers count = PartNumbers::Zero(), square = PartNumbers::Zero();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const ErrorShapes shapes = white.track(i).shapes(kAllParts);
    if (shapes.count() == 0) continue;
    const Eigen::MatrixXd u = white.track(i).whitened(error_columns(shapes));
    RunSums run{u.transpose() * u, u.transpose() * driven[i].topRows(u.rows()), {}};
    for (Eigen::Index j = 0; j < u.cols(); ++j) {
      run.part.push_back(shapes.part[static_cast<std::size_t>(j / 2)]);
      square(static_cast<Eigen::Index>(run.part.back())) += run.shapes(j, j);
      count(static_cast<Eigen::Index>(run.part.back())) += 1;
    }
    sums.runs.push_back(std::move(run));
  }
  sums.unit = count.array().max(1) / square.array().max(1e-300);
  return sums;
}

/// The restricted likelihood at variances (in their units), its slope, Fisher's information, and what the
/// unknowns' covariance does.
struct Likelihood {
  double log = 0;
  PartNumbers slope = PartNumbers::Zero();
  PartSquare information = PartSquare::Zero();
  Eigen::MatrixXd covariance;
  std::array<Eigen::MatrixXd, kErrorParts> by_variance;  ///< of the covariance
};

Likelihood likelihood_at(const Sums& sums, const PartNumbers& variances) {
  const Eigen::Index p = sums.data.cols() - 1;
  Likelihood result;
  Eigen::MatrixXd data = sums.data;             // [J r]' V^-1 [J r]
  std::vector<Eigen::MatrixXd> inside, across;  // U'V^-1 U and U'V^-1 [J r] of each run, in the parts' units
  for (const RunSums& run : sums.runs) {
    const auto m = static_cast<Eigen::Index>(run.part.size());
    Eigen::VectorXd root(m), unit(m);
    for (Eigen::Index j = 0; j < m; ++j) {
      const auto part = static_cast<Eigen::Index>(run.part[static_cast<std::size_t>(j)]);
      unit(j) = std::sqrt(sums.unit(part));
      root(j) = std::sqrt(variances(part)) * unit(j);
    }
    const Eigen::MatrixXd shapes = root.asDiagonal() * run.shapes;
    const Factor factor(Eigen::MatrixXd(shapes * root.asDiagonal()) + Eigen::MatrixXd::Identity(m, m));
    result.log -= factor.log_determinant_of_root();
    const Eigen::MatrixXd l_shapes = factor.whitened(shapes),
                          l_data = factor.whitened(root.asDiagonal() * run.data);
    inside.push_back(unit.asDiagonal() * (run.shapes - l_shapes.transpose() * l_shapes) * unit.asDiagonal());
    across.push_back(unit.asDiagonal() * (run.data - l_shapes.transpose() * l_data));
    data -= l_data.transpose() * l_data;
  }
  const Eigen::MatrixXd normal = data.topLeftCorner(p, p);
  const PseudoInverse inverse = pseudo_inverse(normal, unit_diagonal(normal), 1e-13);
  const Eigen::MatrixXd& s = result.covariance = inverse.inverse;
  const Eigen::VectorXd by_r = data.topRightCorner(p, 1), shift = s * by_r;
  result.log -= 0.5 * (inverse.log_determinant + data(p, p) - by_r.dot(shift));
  std::array<Eigen::MatrixXd, kErrorParts> squares;  // sums of J' V^-1 u u' V^-1 J
  squares.fill(Eigen::MatrixXd::Zero(p, p));
  for (std::size_t i = 0; i < sums.runs.size(); ++i) {
    const auto& part = sums.runs[i].part;
    const Eigen::MatrixXd by_x = across[i].leftCols(p), taken = by_x * s * by_x.transpose();
    const Eigen::MatrixXd projected = inside[i] - taken;
    const Eigen::VectorXd score = across[i].col(p) - by_x * shift;
    for (std::size_t a = 0; a < part.size(); ++a) {
      const auto k = static_cast<Eigen::Index>(a), g = static_cast<Eigen::Index>(part[a]);
      result.slope(g) += 0.5 * (score(k) * score(k) - projected(k, k));
      squares[part[a]] += by_x.row(k).transpose() * by_x.row(k);
      for (std::size_t b = 0; b < part.size(); ++b) {  // runs among themselves, less what is added at last
        const auto l = static_cast<Eigen::Index>(b), h = static_cast<Eigen::Index>(part[b]);
        result.information(g, h) += 0.5 * (projected(k, l) * projected(k, l) - taken(k, l) * taken(k, l));
      }
    }
  }
  for (std::size_t g = 0; g < kErrorParts; ++g) {
    for (std::size_t h = 0; h < kErrorParts; ++h)
      result.information(static_cast<Eigen::Index>(g), static_cast<Eigen::Index>(h)) +=
          0.5 * (squares[g] * s).cwiseProduct((squares[h] * s).transpose()).sum();
    result.by_variance[g] = s * squares[g] * s;
  }
  return result;
}

/// Of twice the log-likelihood. The parts stand or fall together: one left out by a test is one taken as
/// exactly 0, and intervals after it are too short wherever it nearly passed (a drift beside a walk, which
/// explains most of a line, hardly ever does). By chance all four gain as much in 2 % of campaigns
/// (chi-bar-squared: half of them are 0 by chance).
constexpr double kLeastGain = 8.5;
constexpr int kRounds = 60;
constexpr double kArrived = 1e-3;  ///< of the log-likelihood

struct Place {
  PartNumbers variances;
  Likelihood likelihood;
};

/// Fisher's scoring, no part below 0.
Place most_likely(const Sums& sums, const PartNumbers& variances) {
  Place here{variances, likelihood_at(sums, variances)};
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
      there.likelihood = likelihood_at(sums, there.variances);
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
  const Sums sums = sums_of(residuals, values);
  if (sums.runs.empty()) return result;

  const PartNumbers guess = Eigen::Map<const PartNumbers>(residuals.excess_variance().correlated.data());
  const Place place = most_likely(sums, guess.cwiseQuotient(sums.unit));
  result.log_likelihood = likelihood_at(sums, PartNumbers::Zero()).log;
  if (2 * (place.likelihood.log - result.log_likelihood) < kLeastGain) return result;

  const PartNumbers& best = place.variances;
  const Likelihood& at = place.likelihood;
  std::vector<Eigen::Index> present;
  for (Eigen::Index g = 0; g < best.size(); ++g)
    if (best(g) > 0) present.push_back(g);
  if (present.empty()) return result;
  result.log_likelihood = at.log;
  const Eigen::MatrixXd information = at.information(present, present);
  const Eigen::MatrixXd spread = inverse_symmetric(information);
  for (const Eigen::Index g : present) result.variances[static_cast<std::size_t>(g)] = best(g) * sums.unit(g);
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
