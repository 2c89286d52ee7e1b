#include "fit/variances/correlated_likelihood.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "fit/tools/dense.h"

namespace tribotrack::fit::internal {
namespace {

/// What is common to the runs is a vector of unknowns more, known beforehand to be 0 +- the root of its
/// variance: with X = [C G_c^(1/2), J] and S = (X' V_0^-1 X + diag(1, 0))^-1, V_0 the runs' own covariance,
/// P = V_0^-1 - V_0^-1 X S X' V_0^-1, and S holds the unknowns' covariance.
class LikelihoodAt {
 public:
  LikelihoodAt(const CorrelatedSums& sums, const PartNumbers& variances)
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
    for (std::size_t g = 0; g < kErrorParts; ++g)
      for (std::size_t h = 0; h < kErrorParts; ++h)
        result.information(static_cast<Eigen::Index>(g), static_cast<Eigen::Index>(h)) +=
            0.5 * (squares_[g] * s_).cwiseProduct((squares_[h] * s_).transpose()).sum();
    for (std::size_t g = 0; g < kErrorParts; ++g) {
      const Eigen::MatrixXd moved = s_ * (is_common(g) ? common_squares_[g] : squares_[g]) * s_;
      result.by_variance[g] = moved.bottomRightCorner(unknowns_, unknowns_);
    }
    result.covariance = s_.bottomRightCorner(unknowns_, unknowns_);
  }

  CorrelatedLikelihood result;

 private:
  Eigen::Index shared() const { return common_root_.size(); }
  Eigen::Index width() const { return shared() + unknowns_; }

  /// U'V_0^-1 U and U' V_0^-1 [C J r] of each run, [C J r]' V_0^-1 [C J r] of all. U and C in their units.
  void eliminate_runs() {
    data_ = Eigen::MatrixXd::Zero(width() + 1, width() + 1);
    data_.bottomRightCorner(unknowns_ + 1, unknowns_ + 1) = sums_.data;
    for (const CorrelatedRunSums& run : sums_.runs) {
      const auto m = static_cast<Eigen::Index>(run.part.size());
      Eigen::VectorXd root(m), unit(m);
      for (Eigen::Index j = 0; j < m; ++j) {
        const auto part = static_cast<Eigen::Index>(run.part[static_cast<std::size_t>(j)]);
        unit(j) = std::sqrt(sums_.unit(part));
        root(j) = std::sqrt(variances_(part)) * unit(j);
      }
      const Eigen::MatrixXd shapes = root.asDiagonal() * run.shapes, own = root.asDiagonal() * run.data;
      const Factor factor(Eigen::MatrixXd(shapes * root.asDiagonal()) + Eigen::MatrixXd::Identity(m, m));
      result.log -= factor.log_determinant_of_root();
      const Eigen::MatrixXd l_shapes = factor.whitened(shapes), l_own = factor.whitened(own);
      const Eigen::MatrixXd bare = run.shapes - l_shapes.transpose() * l_shapes;
      Eigen::MatrixXd across = Eigen::MatrixXd::Zero(m, width() + 1);
      across.rightCols(unknowns_ + 1) = run.data - l_shapes.transpose() * l_own;
      data_.bottomRightCorner(unknowns_ + 1, unknowns_ + 1) -= l_own.transpose() * l_own;
      if (shared() > 0) {
        const Eigen::MatrixXd to_common = run.to_common * common_unit_.asDiagonal();
        const Eigen::MatrixXd c = bare * to_common;
        across.leftCols(shared()) = c;
        data_.topLeftCorner(shared(), shared()) += to_common.transpose() * c;
        data_.topRightCorner(shared(), unknowns_ + 1) +=
            to_common.transpose() * across.rightCols(unknowns_ + 1);
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
    const PseudoInverse inverse = pseudo_inverse(normal, unit_diagonal(normal), 1e-13);
    s_ = inverse.inverse;
    const Eigen::VectorXd by_r = scale_.cwiseProduct(data_.topRightCorner(p, 1).col(0));
    shift_ = s_ * by_r;
    result.log -= 0.5 * (inverse.log_determinant + data_(p, p) - by_r.dot(shift_));
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

  const CorrelatedSums& sums_;
  const PartNumbers& variances_;
  Eigen::Index unknowns_;
  Eigen::VectorXd common_unit_, common_root_;
  Eigen::MatrixXd data_, s_, by_common_;  ///< by_common_: C' V_0^-1 X
  Eigen::VectorXd scale_, shift_;
  std::vector<Eigen::MatrixXd> inside_, across_;
  std::array<Eigen::MatrixXd, kErrorParts> squares_, common_squares_;  ///< sums of X' V_0^-1 u u' V_0^-1 X
};

}  // namespace

CorrelatedLikelihood correlated_likelihood_at(const CorrelatedSums& sums, const PartNumbers& variances) {
  return LikelihoodAt(sums, variances).result;
}

namespace {

constexpr int kFewestSharing = 3;  ///< runs: what two share is hardly separable from their own

/// The part common to all runs that has the shape of a run's own; nothing for the walk.
std::optional<std::size_t> common_of(std::size_t part) {
  switch (static_cast<ErrorPart>(part)) {
    case ErrorPart::drift:
      return static_cast<std::size_t>(ErrorPart::common_drift);
    case ErrorPart::circle:
      return static_cast<std::size_t>(ErrorPart::common_circle);
    case ErrorPart::overtones:
      return static_cast<std::size_t>(ErrorPart::common_overtones);
    default:
      return std::nullopt;
  }
}

/// A run's columns of own shapes turned into its columns of common ones, and the common parts of these.
Eigen::MatrixXd common_columns(const ErrorShapes& shapes, std::vector<std::size_t>& parts) {
  parts.clear();
  Eigen::MatrixXd result(2 * static_cast<Eigen::Index>(shapes.count()), 0);
  for (std::size_t j = 0; j < shapes.count(); ++j) {
    const auto common = common_of(shapes.part[j]);
    if (!common) continue;
    ErrorShapes as_common;
    as_common.part = {*common};
    as_common.way = shapes.way;
    const Eigen::Index column = result.cols();
    result.conservativeResize(Eigen::NoChange, column + 2);
    result.rightCols<2>().setZero();
    result.block<2, 2>(2 * static_cast<Eigen::Index>(j), column) = as_common.axes(0);
    parts.insert(parts.end(), 2, *common);
  }
  return result;
}

}  // namespace

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
  int sharing = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const ErrorShapes shapes = white.track(i).shapes(kOwnParts);
    if (shapes.count() == 0) continue;
    const Eigen::MatrixXd u = white.track(i).whitened(error_columns(shapes));
    std::vector<std::size_t> common_part;
    CorrelatedRunSums run{u.transpose() * u,
                          u.transpose() * driven[i].topRows(u.rows()),
                          {},
                          common_columns(shapes, common_part)};
    if (common_part.size() > sums.common_part.size()) sums.common_part = common_part;
    ++sharing;
    for (Eigen::Index j = 0; j < u.cols(); ++j) {
      run.part.push_back(shapes.part[static_cast<std::size_t>(j / 2)]);
      square(static_cast<Eigen::Index>(run.part.back())) += run.shapes(j, j);
      count(static_cast<Eigen::Index>(run.part.back())) += 1;
    }
    sums.runs.push_back(std::move(run));
  }
  sums.common = sharing >= kFewestSharing;
  for (CorrelatedRunSums& run : sums.runs)  // one whose platform rests shares nothing
    if (const auto all = static_cast<Eigen::Index>(sums.common_part.size()); run.to_common.cols() != all)
      run.to_common.setZero(run.shapes.rows(), all);
  sums.unit = count.array().max(1) / square.array().max(1e-300);
  for (std::size_t part = 0; part < kErrorParts; ++part)
    if (const auto common = common_of(part))
      sums.unit(static_cast<Eigen::Index>(*common)) =
          sums.unit(static_cast<Eigen::Index>(part)) / std::max(1, sharing);
  return sums;
}

}  // namespace tribotrack::fit::internal
