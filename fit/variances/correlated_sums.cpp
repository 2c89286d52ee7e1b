#include "fit/variances/correlated_sums.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace tribotrack::fit::internal {
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
  Eigen::VectorXd r;
  Eigen::MatrixXd rows;
  CorrelatedSums sums;
  if (!white.evaluate(values, r, &rows)) return sums;
  const Eigen::VectorXd units = residuals.unknowns().natural_units(values);
  rows *= units.asDiagonal();
  rows.conservativeResize(Eigen::NoChange, rows.cols() + 1);
  rows.rightCols<1>() = r;
  sums.data = rows.transpose() * rows;
  PartNumbers count = PartNumbers::Zero(), square = PartNumbers::Zero();
  int sharing = 0;
  for (std::size_t i = 0; i < residuals.excess_variance().trajectories.size(); ++i) {
    const ErrorShapes shapes = white.shapes(i, kOwnParts);
    if (shapes.count() == 0) continue;
    const Eigen::MatrixXd u = white.whitened(i, error_columns(shapes));
    std::vector<std::size_t> common_part;
    CorrelatedRunSums run{u.transpose() * u,
                          u.transpose() * rows.middleRows(white.trajectory_row(i), u.rows()),
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
