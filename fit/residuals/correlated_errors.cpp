#include "fit/residuals/correlated_errors.h"

#include <cmath>
#include <numbers>

#include "fit/tools/dense.h"

namespace tribotrack::fit::internal {
namespace {

using std::numbers::pi;

std::size_t index(ErrorPart part) {
  return static_cast<std::size_t>(part);
}

}  // namespace

Eigen::Matrix2d ErrorShapes::axes(std::size_t j) const {
  if (part[j] != index(ErrorPart::common_drift)) return Eigen::Matrix2d::Identity();
  return (Eigen::Matrix2d() << way.x(), -way.y(), way.y(), way.x()).finished();
}

ErrorShapes error_shapes(const std::vector<double>& times, double w, double start_phase,
                         double reference_time, const ErrorParts& wanted) {
  ErrorShapes shapes;
  const auto n = static_cast<Eigen::Index>(times.size());
  const Eigen::ArrayXd t = Eigen::Map<const Eigen::ArrayXd>(times.data(), n);
  const double duration = times.back();
  std::vector<Eigen::ArrayXd> columns;
  const auto add = [&](ErrorPart part, const Eigen::ArrayXd& column) {
    if (!wanted[index(part)]) return;
    columns.push_back(column);
    shapes.part.push_back(index(part));
  };
  add(ErrorPart::drift, (t - 0.5 * duration) / reference_time);
  for (std::size_t k = 1; k <= kWalkModes; ++k) {
    const double rate = (static_cast<double>(k) - 0.5) * pi;
    add(ErrorPart::walk, std::sqrt(2 * duration / reference_time) / rate * (rate / duration * t).sin());
  }
  const auto add_sines = [&](ErrorPart first, ErrorPart others) {
    for (int order = 1; order <= 3 && w > 0; ++order) {
      const ErrorPart part = order == 1 ? first : others;
      if (!wanted[index(part)]) continue;
      add(part, (order * (start_phase + w * t)).cos());
      add(part, (order * (start_phase + w * t)).sin());
    }
  };
  add_sines(ErrorPart::circle, ErrorPart::overtones);
  add_sines(ErrorPart::common_circle, ErrorPart::common_overtones);
  add(ErrorPart::common_drift, (t - 0.5 * duration) / reference_time);
  shapes.values.resize(n, static_cast<Eigen::Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j)
    shapes.values.col(static_cast<Eigen::Index>(j)) = columns[j];
  return shapes;
}

Eigen::MatrixXd error_columns(const ErrorShapes& shapes) {
  const Eigen::Index points = shapes.values.rows();
  Eigen::MatrixXd columns(2 * points, 2 * shapes.values.cols());
  for (Eigen::Index j = 0; j < shapes.values.cols(); ++j) {
    const Eigen::Matrix2d axes = shapes.axes(static_cast<std::size_t>(j));
    for (Eigen::Index i = 0; i < points; ++i) columns.block<2, 2>(2 * i, 2 * j) = shapes.values(i, j) * axes;
  }
  return columns;
}

Eigen::MatrixXd whitened_columns(Eigen::MatrixXd columns, const PointWhitening& points,
                                 const Eigen::MatrixX2d& start) {
  points.apply(Eigen::Ref<Eigen::MatrixXd>(columns));
  columns -= start * (start.transpose() * columns).eval();
  return columns;
}

Eigen::VectorXd column_variances(const ErrorShapes& shapes, const CorrelatedVariances& variances) {
  Eigen::VectorXd result(2 * static_cast<Eigen::Index>(shapes.count()));
  for (std::size_t j = 0; j < shapes.count(); ++j)
    result.segment<2>(2 * static_cast<Eigen::Index>(j)).setConstant(variances[shapes.part[j]]);
  return result;
}

CorrelatedWhitening::CorrelatedWhitening(Eigen::MatrixXd shapes, const Eigen::VectorXd& variances)
    : shapes_(std::move(shapes)) {
  const Eigen::VectorXd roots = variances.cwiseSqrt();
  shapes_ = (shapes_ * roots.asDiagonal()).eval();
  const EigenSystem eigen = eigen_symmetric(shapes_.transpose() * shapes_);
  const Eigen::ArrayXd l = eigen.values.array().max(0);
  shapes_ = (shapes_ * eigen.vectors).eval();
  turned_ = roots.asDiagonal() * eigen.vectors;
  // (1 - 1/s)/(s^2 - 1) with s^2 = 1 + l, without its cancellation.
  const Eigen::ArrayXd s = (1 + l).sqrt();
  root_ = (1 / (s * (s + 1))).matrix();
  expected_ = (1 / (1 + l)).matrix();
  rows_taken_ = (l / (1 + l)).sum();
}

void CorrelatedWhitening::apply(Eigen::Ref<Eigen::VectorXd> column) const {
  if (empty() || column.isZero(0)) return;
  const Eigen::VectorXd along = root_.cwiseProduct(shapes_.transpose() * column);
  column.noalias() -= shapes_ * along;
}

// With S = U G^(1/2) R, S'S = diag(l), and x = V^(-1/2) y: S' V^-1 y = S' V^(-1/2) x = diag((1 + l)^(-1/2))
// S' x.
Eigen::VectorXd CorrelatedWhitening::coefficients(const Eigen::VectorXd& whitened) const {
  return turned_ * expected_.cwiseSqrt().cwiseProduct(shapes_.transpose() * whitened);
}

}  // namespace tribotrack::fit::internal
