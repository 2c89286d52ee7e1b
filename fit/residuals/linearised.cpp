#include "fit/residuals/linearised.h"

#include <algorithm>

#include "fit/tools/dense.h"

namespace tribotrack::fit::internal {
namespace {

/// Columns of length 1; those that are zero stay so.
Eigen::MatrixXd normalised(const Eigen::MatrixXd& columns) {
  const Eigen::RowVectorXd lengths = columns.colwise().norm().cwiseMax(1e-300);  // once, not for each element
  return columns * lengths.cwiseInverse().asDiagonal();
}

}  // namespace

double Linearised::chi2() const {
  double sum = 0;
  for (const RowGroup& group : groups) sum += group.residuals.squaredNorm();
  return sum;
}

bool Linearised::finite() const {
  return std::all_of(groups.begin(), groups.end(), [](const RowGroup& group) {
    return group.residuals.allFinite() && group.shared.allFinite() && group.own.allFinite();
  });
}

double Linearised::squared(const Eigen::VectorXd& step) const {
  double sum = 0;
  for (const RowGroup& group : groups)
    sum += (group.shared * step.head(group.shared.cols()) +
            group.own * step.segment(group.first_own, group.own.cols()))
               .squaredNorm();
  return sum;
}

Linearised Linearised::scaled(const Eigen::VectorXd& units) const {
  Linearised result = *this;
  for (RowGroup& group : result.groups) {
    group.shared *= units.head(group.shared.cols()).asDiagonal();
    group.own *= units.segment(group.first_own, group.own.cols()).asDiagonal();
  }
  return result;
}

Linearised Linearised::eliminated() const {
  Linearised result = *this;
  for (RowGroup& group : result.groups) {
    if (group.own.cols() == 0) continue;
    const Eigen::MatrixXd q = orthonormal_basis(normalised(group.own));
    group.shared -= q * (q.transpose() * group.shared).eval();
    group.residuals -= q * (q.transpose() * group.residuals).eval();
    group.own.resize(group.shared.rows(), 0);
  }
  return result;
}

Eigen::MatrixXd Linearised::normal() const {
  const Eigen::Index n = groups.front().shared.cols();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n, n);
  for (const RowGroup& group : groups) sum += group.shared.transpose() * group.shared;
  return sum;
}

Eigen::VectorXd Linearised::gradient() const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(groups.front().shared.cols());
  for (const RowGroup& group : groups) sum += group.shared.transpose() * group.residuals;
  return sum;
}

Eigen::MatrixXd Linearised::triangle() const {
  Eigen::MatrixXd result(0, groups.front().shared.cols());
  for (const RowGroup& group : groups) {
    Eigen::MatrixXd stacked(result.rows() + group.shared.rows(), result.cols());
    stacked.topRows(result.rows()) = result;
    stacked.bottomRows(group.shared.rows()) = group.shared;
    result = stacked.rows() > stacked.cols() ? triangle_of(std::move(stacked)) : stacked;
  }
  return result;
}

Eigen::VectorXd Linearised::following(const Eigen::VectorXd& shared_step, Eigen::Index unknowns) const {
  Eigen::VectorXd step = Eigen::VectorXd::Zero(unknowns);
  step.head(shared_step.size()) = shared_step;
  for (const RowGroup& group : groups)
    if (group.own.cols() > 0)
      step.segment(group.first_own, group.own.cols()) =
          -least_squares(normalised(group.own), group.shared * shared_step)
               .cwiseQuotient(group.own.colwise().norm().transpose().cwiseMax(1e-300));
  return step;
}

Eigen::VectorXd Linearised::residuals() const {
  Eigen::VectorXd all;
  for (const RowGroup& group : groups) {
    all.conservativeResize(all.size() + group.residuals.size());
    all.tail(group.residuals.size()) = group.residuals;
  }
  return all;
}

Eigen::MatrixXd Linearised::jacobian(Eigen::Index unknowns) const {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(residuals().size(), unknowns);
  Eigen::Index row = 0;
  for (const RowGroup& group : groups) {
    const Eigen::Index rows = group.residuals.size();
    all.block(row, 0, rows, group.shared.cols()) = group.shared;
    all.block(row, group.first_own, rows, group.own.cols()) = group.own;
    row += rows;
  }
  return all;
}

// Scaled by the normal matrix with nothing eliminated: a column that others imitate is then as small as
// rounding makes it.
double newton_decrement(const Linearised& at, std::optional<Eigen::Index> held) {
  const Linearised left = at.eliminated();
  double by_own = 0;  // what the own unknowns take
  for (std::size_t g = 0; g < at.groups.size(); ++g)
    by_own += (at.groups[g].residuals - left.groups[g].residuals).squaredNorm();
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < at.groups.front().shared.cols(); ++i)
    if (i != held) free.push_back(i);
  if (free.empty()) return by_own;
  const Eigen::VectorXd gradient = left.gradient()(free);
  return by_own +
         gradient.dot(
             pseudo_inverse(left.normal()(free, free), unit_diagonal(at.normal())(free), 1e-13).inverse *
             gradient);
}

Eigen::MatrixXd shared_covariance(const Linearised& at, double flat) {
  return pseudo_inverse(at.eliminated().normal(), unit_diagonal(at.normal()), flat).inverse;
}

}  // namespace tribotrack::fit::internal
