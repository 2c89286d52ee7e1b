#include "fit/internal/slow_variances.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <tuple>

namespace tribotrack::fit::internal {
namespace {

/// Of twice the log-likelihood. What is common to all runs is told by few coefficients and, where it is there
/// by chance, costs most: chances are 2 % and 0.7 % (half of chi^2 with one degree of freedom).
constexpr double kAsks = 4, kCommonAsks = 6;
constexpr int kRounds = 60;
constexpr int kFewestSharing = 3;  ///< runs: what two share is hardly told from their own
constexpr double kArrived = 1e-3;  ///< of the log-likelihood

using Parts = Eigen::Matrix<double, static_cast<int>(kSlowParts), 1>;
using PartsSquare = Eigen::Matrix<double, static_cast<int>(kSlowParts), static_cast<int>(kSlowParts)>;

/// All that the likelihood needs of one run: U'U and U'[J r].
struct RunSums {
  Eigen::MatrixXd shapes, data;
  std::vector<std::size_t> part;     ///< of each column of U
  std::vector<Eigen::Index> common;  ///< the columns that, one below the other, are those common to all runs
};

struct Sums {
  std::vector<RunSums> runs;
  Eigen::MatrixXd data;  ///< [J r]'[J r] of all rows
  Parts unit;            ///< m^2: the variance of each part at which it is as large as the white noise
  std::vector<std::size_t> common_part;  ///< of each common column
  bool common = false;                   ///< whether runs are enough to tell what they share
};

/// Where a run's own part goes among the common ones.
std::size_t common_of(std::size_t part) {
  return static_cast<std::size_t>(part == static_cast<std::size_t>(SlowPart::circle)
                                      ? SlowPart::common_circle
                                      : SlowPart::common_overtones);
}

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
  int sharing = 0;
  for (std::size_t i = 0; i < residuals.scatter().trajectories.size(); ++i) {
    const SlowShapes shapes = white.shapes(i, kOwnSlowParts);
    if (shapes.count() == 0) continue;
    const Eigen::MatrixXd u = whitened_shapes(shapes, white.white(i));
    RunSums run{
        u.transpose() * u, u.transpose() * rows.middleRows(white.trajectory_row(i), u.rows()), {}, {}};
    std::vector<std::size_t> common_part;
    for (Eigen::Index j = 0; j < u.cols(); ++j) {
      run.part.push_back(shapes.part[static_cast<std::size_t>(j / 2)]);
      if (run.part.back() >= static_cast<std::size_t>(SlowPart::circle)) {
        run.common.push_back(j);
        common_part.push_back(common_of(run.part.back()));
      }
      square(static_cast<Eigen::Index>(run.part.back())) += run.shapes(j, j);
      count(static_cast<Eigen::Index>(run.part.back())) += 1;
    }
    if (!common_part.empty()) sums.common_part = common_part, ++sharing;
    sums.runs.push_back(std::move(run));
  }
  sums.common = sharing >= kFewestSharing;
  sums.unit = count.array().max(1) / square.array().max(1e-300);
  for (const SlowPart own : {SlowPart::circle, SlowPart::overtones}) {
    const auto part = static_cast<std::size_t>(own);
    sums.unit(static_cast<Eigen::Index>(common_of(part))) =
        sums.unit(static_cast<Eigen::Index>(part)) / std::max(1, sharing);
  }
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

/// What is common to the runs is a vector of unknowns more, known beforehand to be 0 +- the root of its
/// variance: with X = [C G_c^(1/2), J] and S = (X' V_0^-1 X + diag(1, 0))^-1, V_0 the runs' own covariance,
/// P = V_0^-1 - V_0^-1 X S X' V_0^-1, and S holds the unknowns' covariance.
class LikelihoodAt {
 public:
  LikelihoodAt(const Sums& sums, const Parts& variances)
      : sums_(sums), variances_(variances), unknowns_(sums.data.cols() - 1) {
    for (std::size_t k = 0; sums.common && k < sums.common_part.size(); ++k) {
      const auto part = static_cast<Eigen::Index>(sums.common_part[k]);
      common_unit_.conservativeResize(common_unit_.size() + 1);
      common_unit_.tail<1>()(0) = std::sqrt(sums.unit(part));
      common_root_.conservativeResize(common_unit_.size());
      common_root_.tail<1>()(0) = std::sqrt(variances(part));
    }
    eliminate_runs();
    solve();
    for (std::size_t i = 0; i < sums.runs.size(); ++i) add_run(i);
    add_common();
    for (std::size_t g = 0; g < kSlowParts; ++g)
      for (std::size_t h = 0; h < kSlowParts; ++h)
        result.information(static_cast<Eigen::Index>(g), static_cast<Eigen::Index>(h)) +=
            0.5 * (squares_[g] * s_).cwiseProduct((squares_[h] * s_).transpose()).sum();
    for (std::size_t g = 0; g < kSlowParts; ++g) {
      const Eigen::MatrixXd moved = s_ * (is_common(g) ? common_squares_[g] : squares_[g]) * s_;
      result.by_variance[g] = moved.bottomRightCorner(unknowns_, unknowns_);
    }
    result.covariance = s_.bottomRightCorner(unknowns_, unknowns_);
  }

  Likelihood result;

 private:
  Eigen::Index shared() const { return common_root_.size(); }
  Eigen::Index width() const { return shared() + unknowns_; }

  /// U'V_0^-1 U and U' V_0^-1 [C J r] of each run, [C J r]' V_0^-1 [C J r] of all. U and C in their units.
  void eliminate_runs() {
    data_ = Eigen::MatrixXd::Zero(width() + 1, width() + 1);
    data_.bottomRightCorner(unknowns_ + 1, unknowns_ + 1) = sums_.data;
    for (const RunSums& run : sums_.runs) {
      const auto m = static_cast<Eigen::Index>(run.part.size());
      Eigen::VectorXd root(m), unit(m);
      for (Eigen::Index j = 0; j < m; ++j) {
        const auto part = static_cast<Eigen::Index>(run.part[static_cast<std::size_t>(j)]);
        unit(j) = std::sqrt(sums_.unit(part));
        root(j) = std::sqrt(variances_(part)) * unit(j);
      }
      const Eigen::MatrixXd shapes = root.asDiagonal() * run.shapes, own = root.asDiagonal() * run.data;
      const Eigen::LLT<Eigen::MatrixXd> factor(Eigen::MatrixXd(shapes * root.asDiagonal()) +
                                               Eigen::MatrixXd::Identity(m, m));
      result.log -= factor.matrixLLT().diagonal().array().log().sum();
      const Eigen::MatrixXd l_shapes = factor.matrixL().solve(shapes), l_own = factor.matrixL().solve(own);
      const Eigen::MatrixXd bare = run.shapes - l_shapes.transpose() * l_shapes;
      Eigen::MatrixXd across = Eigen::MatrixXd::Zero(m, width() + 1);
      across.rightCols(unknowns_ + 1) = run.data - l_shapes.transpose() * l_own;
      data_.bottomRightCorner(unknowns_ + 1, unknowns_ + 1) -= l_own.transpose() * l_own;
      if (shared() > 0 && !run.common.empty()) {
        const Eigen::MatrixXd c = bare(Eigen::all, run.common) * common_unit_.asDiagonal();
        across.leftCols(shared()) = c;
        data_.topLeftCorner(shared(), shared()) += common_unit_.asDiagonal() * c(run.common, Eigen::all);
        data_.topRightCorner(shared(), unknowns_ + 1) +=
            common_unit_.asDiagonal() * across(run.common, Eigen::lastN(unknowns_ + 1));
      }
      inside_.push_back(unit.asDiagonal() * bare * unit.asDiagonal());
      across_.push_back(unit.asDiagonal() * across);
    }
    data_.bottomLeftCorner(unknowns_ + 1, shared()) =
        data_.topRightCorner(shared(), unknowns_ + 1).transpose();
  }

  void solve() {
    const Eigen::Index p = width();
    scale_ = Eigen::VectorXd::Ones(p);
    scale_.head(shared()) = common_root_;
    Eigen::MatrixXd normal = scale_.asDiagonal() * data_.topLeftCorner(p, p) * scale_.asDiagonal();
    normal.diagonal().head(shared()).array() += 1;
    double log_determinant = 0;
    std::tie(s_, log_determinant) = inverse_of(normal);
    const Eigen::VectorXd by_r = scale_.cwiseProduct(data_.topRightCorner(p, 1).col(0));
    shift_ = s_ * by_r;
    result.log -= 0.5 * (log_determinant + data_(p, p) - by_r.dot(shift_));
    squares_.fill(Eigen::MatrixXd::Zero(p, p));
    common_squares_.fill(Eigen::MatrixXd::Zero(p, p));
    by_common_ = data_.topLeftCorner(shared(), p) * scale_.asDiagonal();
  }

  void add_run(std::size_t i) {
    const auto& part = sums_.runs[i].part;
    const Eigen::MatrixXd by_x = across_[i].leftCols(width()) * scale_.asDiagonal();
    const Eigen::MatrixXd solved = by_x * s_, taken = solved * by_x.transpose();
    const Eigen::MatrixXd projected = inside_[i] - taken;
    const Eigen::VectorXd score = across_[i].col(width()) - by_x * shift_;
    const Eigen::MatrixXd with_common = across_[i].leftCols(shared()) - solved * by_common_.transpose();
    for (std::size_t a = 0; a < part.size(); ++a) {
      const auto k = static_cast<Eigen::Index>(a), g = static_cast<Eigen::Index>(part[a]);
      result.slope(g) += 0.5 * (score(k) * score(k) - projected(k, k));
      squares_[part[a]] += by_x.row(k).transpose() * by_x.row(k);
      for (std::size_t b = 0; b < part.size(); ++b) {  // runs among themselves, less what is added at last
        const auto l = static_cast<Eigen::Index>(b), h = static_cast<Eigen::Index>(part[b]);
        result.information(g, h) += 0.5 * (projected(k, l) * projected(k, l) - taken(k, l) * taken(k, l));
      }
      for (Eigen::Index c = 0; c < shared(); ++c) {
        const auto h = static_cast<Eigen::Index>(sums_.common_part[static_cast<std::size_t>(c)]);
        const double information = 0.5 * with_common(k, c) * with_common(k, c);
        result.information(g, h) += information;
        result.information(h, g) += information;
      }
    }
  }

  void add_common() {
    const Eigen::MatrixXd projected =
        data_.topLeftCorner(shared(), shared()) - by_common_ * s_ * by_common_.transpose();
    const Eigen::VectorXd score = data_.topRightCorner(shared(), 1).col(0) - by_common_ * shift_;
    for (Eigen::Index c = 0; c < shared(); ++c) {
      const std::size_t part = sums_.common_part[static_cast<std::size_t>(c)];
      const auto g = static_cast<Eigen::Index>(part);
      result.slope(g) += 0.5 * (score(c) * score(c) - projected(c, c));
      common_squares_[part] += by_common_.row(c).transpose() * by_common_.row(c);
      for (Eigen::Index d = 0; d < shared(); ++d) {
        const auto h = static_cast<Eigen::Index>(sums_.common_part[static_cast<std::size_t>(d)]);
        result.information(g, h) += 0.5 * projected(c, d) * projected(c, d);
      }
    }
  }

  const Sums& sums_;
  const Parts& variances_;
  Eigen::Index unknowns_;
  Eigen::VectorXd common_unit_, common_root_;
  Eigen::MatrixXd data_, s_, by_common_;  ///< by_common_: C' V_0^-1 X
  Eigen::VectorXd scale_, shift_;
  std::vector<Eigen::MatrixXd> inside_, across_;
  std::array<Eigen::MatrixXd, kSlowParts> squares_, common_squares_;  ///< sums of X' V_0^-1 u u' V_0^-1 X
};

Likelihood likelihood_at(const Sums& sums, const Parts& variances) {
  return LikelihoodAt(sums, variances).result;
}

struct Place {
  Parts variances;
  Likelihood likelihood;
};

/// Fisher's scoring over the parts `allowed`, none below 0.
Place most_likely(const Sums& sums, const SlowWanted& allowed, Parts variances) {
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

double asks_of(std::size_t part) {
  return is_common(part) ? kCommonAsks : kAsks;
}

/// The part that the likelihood asks for least, by Wald's measure over what it has to ask.
std::size_t least_of(const Place& place) {
  std::size_t least = 0;
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t g = 0; g < kSlowParts; ++g) {
    const auto k = static_cast<Eigen::Index>(g);
    const double size = place.variances(k);
    if (!(size > 0)) continue;
    const double asks = size * size * place.likelihood.information(k, k) / asks_of(g);
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

  SlowWanted allowed = kOwnSlowParts;
  for (std::size_t part = 0; part < kSlowParts; ++part)
    if (is_common(part)) allowed[part] = sums.common;
  Parts guess = Eigen::Map<const Parts>(residuals.scatter().slow.data());
  Place place = most_likely(sums, allowed, guess.cwiseQuotient(sums.unit));
  while (place.variances.maxCoeff() > 0) {
    for (std::size_t g = 0; g < kSlowParts; ++g)
      allowed[g] = place.variances(static_cast<Eigen::Index>(g)) > 0;
    const std::size_t least = least_of(place);
    allowed[least] = false;
    Place without = most_likely(sums, allowed, place.variances);
    if (!(2 * (place.likelihood.log - without.likelihood.log) < asks_of(least))) break;
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
