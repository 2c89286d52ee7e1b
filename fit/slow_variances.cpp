#include "fit/internal/slow_variances.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace tribotrack::fit::internal {
namespace {

constexpr double kAsks = 4;  ///< of twice the log-likelihood
constexpr int kRounds = 60;
constexpr double kArrived = 1e-3;  ///< of the log-likelihood

using Parts = Eigen::Matrix<double, static_cast<int>(kSlowParts), 1>;
using PartsSquare = Eigen::Matrix<double, static_cast<int>(kSlowParts), static_cast<int>(kSlowParts)>;

/// All that the likelihood needs of one run: U'U and U'[J r].
struct RunSums {
  Eigen::MatrixXd shapes, data;
  std::vector<std::size_t> part;  ///< of each column of U
};

struct Sums {
  std::vector<RunSums> runs;
  Eigen::MatrixXd data;  ///< [J r]'[J r] of all rows
  Parts unit;            ///< m^2: the variance of each part at which it is as large as the white noise
};

Sums sums_of(const Residuals& residuals, const Eigen::VectorXd& values) {
  Residuals white = residuals;
  Scatter scatter = residuals.scatter();
  scatter.slow = {};
  white.set_scatter(scatter);
  Eigen::VectorXd r;
  Eigen::MatrixXd rows;
  Sums sums;
  if (!white.evaluate(values, r, &rows)) return sums;
  const Eigen::VectorXd units = residuals.unknowns().natural_units(values);
  rows *= units.asDiagonal();
  rows.conservativeResize(Eigen::NoChange, rows.cols() + 1);
  rows.rightCols<1>() = r;
  sums.data = rows.transpose() * rows;
  Parts count = Parts::Zero(), square = Parts::Zero();
  for (std::size_t i = 0; i < residuals.scatter().trajectories.size(); ++i) {
    const SlowShapes shapes = white.shapes(i, {true, true, true, true});
    if (shapes.count() == 0) continue;
    const Eigen::MatrixXd u = whitened_shapes(shapes, white.white(i));
    RunSums run{u.transpose() * u, u.transpose() * rows.middleRows(white.trajectory_row(i), u.rows()), {}};
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

/// The inverse, directions that the data do not see left out, and ln of the determinant of the rest.
std::pair<Eigen::MatrixXd, double> inverse_of(const Eigen::MatrixXd& information) {
  const Eigen::VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * information *
                                                             scale.asDiagonal());
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(information.rows());
  double log_determinant = -2 * scale.array().log().sum();
  for (Eigen::Index i = 0; i < inverse.size(); ++i) {
    if (!(eigen.eigenvalues()(i) > 1e-13)) continue;
    inverse(i) = 1 / eigen.eigenvalues()(i);
    log_determinant += std::log(eigen.eigenvalues()(i));
  }
  return {scale.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal() *
              eigen.eigenvectors().transpose() * scale.asDiagonal(),
          log_determinant};
}

/// The restricted likelihood at variances (in their units), its slope, Fisher's information, and what the
/// unknowns' covariance does.
struct Likelihood {
  double log = 0;
  Parts slope = Parts::Zero();
  PartsSquare information = PartsSquare::Zero();
  Eigen::MatrixXd covariance;
  std::array<Eigen::MatrixXd, kSlowParts> by_variance;  ///< of the covariance
};

Likelihood likelihood_at(const Sums& sums, const Parts& variances) {
  const Eigen::Index p = sums.data.cols() - 1;
  Eigen::MatrixXd data = sums.data;
  std::vector<Eigen::MatrixXd> inside, across;  // U' V^-1 U and U' V^-1 [J r] of each run
  std::vector<Eigen::VectorXd> roots;           // of the units, so that the slopes are by them
  Likelihood result;
  for (const RunSums& run : sums.runs) {
    const auto m = static_cast<Eigen::Index>(run.part.size());
    Eigen::VectorXd root(m), unit(m);
    for (Eigen::Index j = 0; j < m; ++j) {
      const auto part = static_cast<Eigen::Index>(run.part[static_cast<std::size_t>(j)]);
      unit(j) = std::sqrt(sums.unit(part));
      root(j) = std::sqrt(variances(part)) * unit(j);
    }
    const Eigen::MatrixXd shapes = root.asDiagonal() * run.shapes, own = root.asDiagonal() * run.data;
    const Eigen::LLT<Eigen::MatrixXd> factor(Eigen::MatrixXd(shapes * root.asDiagonal()) +
                                             Eigen::MatrixXd::Identity(m, m));
    result.log -= factor.matrixLLT().diagonal().array().log().sum();
    const Eigen::MatrixXd l_shapes = factor.matrixL().solve(shapes), l_own = factor.matrixL().solve(own);
    inside.push_back(unit.asDiagonal() * (run.shapes - l_shapes.transpose() * l_shapes) * unit.asDiagonal());
    across.push_back(unit.asDiagonal() * (run.data - l_shapes.transpose() * l_own));
    data -= l_own.transpose() * l_own;
  }
  const auto [covariance, log_determinant] = inverse_of(data.topLeftCorner(p, p));
  result.covariance = covariance;
  const Eigen::VectorXd shift = covariance * data.topRightCorner(p, 1);
  result.log -= 0.5 * (log_determinant + data(p, p) - data.topRightCorner(p, 1).col(0).dot(shift));

  std::array<Eigen::MatrixXd, kSlowParts> squares;  // sum over runs of J' V^-1 U_g U_g' V^-1 J
  squares.fill(Eigen::MatrixXd::Zero(p, p));
  for (std::size_t i = 0; i < sums.runs.size(); ++i) {
    const auto& part = sums.runs[i].part;
    const Eigen::MatrixXd by_unknowns = across[i].leftCols(p);
    const Eigen::MatrixXd taken = by_unknowns * covariance * by_unknowns.transpose();
    const Eigen::MatrixXd projected = inside[i] - taken;
    const Eigen::VectorXd score = across[i].col(p) - by_unknowns * shift;
    for (std::size_t a = 0; a < part.size(); ++a) {
      const auto k = static_cast<Eigen::Index>(a), g = static_cast<Eigen::Index>(part[a]);
      result.slope(g) += 0.5 * (score(k) * score(k) - projected(k, k));
      squares[part[a]] += by_unknowns.row(k).transpose() * by_unknowns.row(k);
      for (std::size_t b = 0; b < part.size(); ++b) {  // runs among themselves, less what is added below
        const auto l = static_cast<Eigen::Index>(b), h = static_cast<Eigen::Index>(part[b]);
        result.information(g, h) += 0.5 * (projected(k, l) * projected(k, l) - taken(k, l) * taken(k, l));
      }
    }
  }
  for (std::size_t g = 0; g < kSlowParts; ++g) result.by_variance[g] = covariance * squares[g] * covariance;
  for (std::size_t g = 0; g < kSlowParts; ++g)
    for (std::size_t h = 0; h < kSlowParts; ++h)
      result.information(static_cast<Eigen::Index>(g), static_cast<Eigen::Index>(h)) +=
          0.5 * (squares[g] * covariance * squares[h] * covariance).trace();
  return result;
}

struct Place {
  Parts variances;
  Likelihood likelihood;
};

/// Fisher's scoring over the parts `allowed`, none below 0.
Place most_likely(const Sums& sums, const std::array<bool, kSlowParts>& allowed, Parts variances) {
  for (std::size_t g = 0; g < kSlowParts; ++g)
    if (!allowed[g]) variances(static_cast<Eigen::Index>(g)) = 0;
  Place here{variances, likelihood_at(sums, variances)};
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Eigen::Index> moving;
    for (Eigen::Index g = 0; g < variances.size(); ++g)
      if (allowed[static_cast<std::size_t>(g)] && (here.variances(g) > 0 || here.likelihood.slope(g) > 0))
        moving.push_back(g);
    if (moving.empty()) break;
    const Eigen::MatrixXd information = here.likelihood.information(moving, moving);
    const Eigen::VectorXd slope = here.likelihood.slope(moving), step = information.ldlt().solve(slope);
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

/// The part that the likelihood asks for least, by Wald's measure.
std::size_t least_of(const Place& place) {
  std::size_t least = 0;
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t g = 0; g < kSlowParts; ++g) {
    const auto k = static_cast<Eigen::Index>(g);
    const double size = place.variances(k);
    if (!(size > 0)) continue;
    const double asks = size * size * place.likelihood.information(k, k);
    if (asks < lowest) lowest = asks, least = g;
  }
  return least;
}

}  // namespace

SlowEstimate estimate_slow_errors(const Residuals& residuals, const Eigen::VectorXd& values) {
  SlowEstimate result;
  result.degrees_of_freedom =
      Eigen::VectorXd::Constant(values.size(), std::numeric_limits<double>::infinity());
  const Sums sums = sums_of(residuals, values);
  if (sums.runs.empty()) return result;

  std::array<bool, kSlowParts> allowed{true, true, true, true};
  Parts guess = Eigen::Map<const Parts>(residuals.scatter().slow.data());
  Place place = most_likely(sums, allowed, guess.cwiseQuotient(sums.unit));
  while (place.variances.maxCoeff() > 0) {
    for (std::size_t g = 0; g < kSlowParts; ++g)
      allowed[g] = place.variances(static_cast<Eigen::Index>(g)) > 0;
    allowed[least_of(place)] = false;
    Place without = most_likely(sums, allowed, place.variances);
    if (!(2 * (place.likelihood.log - without.likelihood.log) < kAsks)) break;
    place = std::move(without);
  }

  const Parts& best = place.variances;
  const Likelihood& at = place.likelihood;
  std::vector<Eigen::Index> present;
  for (Eigen::Index g = 0; g < best.size(); ++g)
    if (best(g) > 0) present.push_back(g);
  if (present.empty()) return result;
  const Eigen::MatrixXd information = at.information(present, present);
  const Eigen::MatrixXd spread =
      information.ldlt().solve(Eigen::MatrixXd::Identity(information.rows(), information.cols()));
  for (std::size_t k = 0; k < present.size(); ++k) {
    const auto g = static_cast<std::size_t>(present[k]);
    const auto row = static_cast<Eigen::Index>(k);
    result.variances[g] = best(present[k]) * sums.unit(present[k]);
    result.sd[g] = std::sqrt(spread(row, row)) * sums.unit(present[k]);
  }
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    Eigen::VectorXd slopes(static_cast<Eigen::Index>(present.size()));
    for (std::size_t k = 0; k < present.size(); ++k)
      slopes(static_cast<Eigen::Index>(k)) = at.by_variance[static_cast<std::size_t>(present[k])](i, i);
    const double variance = at.covariance(i, i), of_variance = slopes.dot(spread * slopes);
    if (of_variance > 0) result.degrees_of_freedom(i) = 2 * variance * variance / of_variance;
  }
  return result;
}

}  // namespace tribotrack::fit::internal
