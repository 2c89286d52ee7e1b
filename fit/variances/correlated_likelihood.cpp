#include "fit/variances/correlated_likelihood.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "fit/tools/dense.h"

namespace tribotrack::fit::internal {
CorrelatedLikelihood correlated_likelihood_at(const CorrelatedSums& sums, const PartNumbers& variances) {
  const Eigen::Index p = sums.data.cols() - 1;
  CorrelatedLikelihood result;
  Eigen::MatrixXd data = sums.data;             // [J r]' V^-1 [J r]
  std::vector<Eigen::MatrixXd> inside, across;  // U'V^-1 U and U'V^-1 [J r] of each run, in the parts' units
  for (const CorrelatedRunSums& run : sums.runs) {
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

CorrelatedSums correlated_sums_of(const Residuals& residuals, const Eigen::VectorXd& values) {
  Residuals white = residuals;
  ExcessVariance scatter = residuals.excess_variance();
  scatter.correlated = {};
  white.set_excess_variance(scatter);
  CorrelatedSums sums;
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
    CorrelatedRunSums run{u.transpose() * u, u.transpose() * driven[i].topRows(u.rows()), {}};
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

}  // namespace tribotrack::fit::internal
