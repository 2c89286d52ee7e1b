#include "fit/pooling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "fit/tools/statistics.h"

namespace tribotrack::fit {
namespace {

/// Exact values: equal to rounding, or refused.
Pooled pool_exact(std::span<const Estimate> exact) {
  Pooled pooled;
  pooled.count = exact.size();
  pooled.mean = {exact.front().value, 0};
  for (const Estimate& e : exact)
    if (std::abs(e.value - pooled.mean.value) > 1e-12 * std::abs(pooled.mean.value)) {
      pooled.chi2 = std::numeric_limits<double>::infinity();
      pooled.p_value = 0;
    }
  return pooled;
}

}  // namespace

Pooled pool(std::span<const Estimate> values) {
  if (values.empty()) throw std::invalid_argument("pool: no value");
  std::vector<Estimate> exact;
  double weights = 0, sum = 0;
  for (const Estimate& value : values) {
    if (!(value.sd >= 0) || !std::isfinite(value.sd) || !std::isfinite(value.value))
      throw std::invalid_argument("pool: a value or its sd is no number");
    if (value.sd == 0) exact.push_back(value);
    weights += 1 / (value.sd * value.sd);
    sum += value.value / (value.sd * value.sd);
  }
  if (!exact.empty()) return pool_exact(exact);
  Pooled pooled;
  pooled.count = values.size();
  pooled.mean = {sum / weights, std::sqrt(1 / weights)};
  for (const Estimate& value : values)
    pooled.chi2 += std::pow(value.value - pooled.mean.value, 2) / (value.sd * value.sd);
  const double dof = static_cast<double>(values.size()) - 1;
  pooled.p_value = internal::chi2_survival(pooled.chi2, dof);
  if (!pooled.one_value()) pooled.mean.sd *= std::sqrt(pooled.chi2 / dof);
  return pooled;
}

Pooled pool_angles(std::span<const Estimate> values) {
  if (values.empty()) throw std::invalid_argument("pool: no value");
  const double first = values.front().value;
  std::vector<Estimate> differences;
  for (const Estimate& angle : values)
    differences.push_back({std::remainder(angle.value - first, 2 * std::numbers::pi), angle.sd});
  Pooled pooled = pool(differences);
  pooled.mean.value += first;
  return pooled;
}

Estimate combined(const Estimate& first, const Estimate& second) {
  if (!(first.sd > 0)) return first;
  if (!(second.sd > 0)) return second;
  const double a = 1 / (first.sd * first.sd), b = 1 / (second.sd * second.sd);
  return {(a * first.value + b * second.value) / (a + b), 1 / std::sqrt(a + b)};
}

void take_in(Eigen::VectorXd& values, Eigen::MatrixXd& covariance, Eigen::Index i, const Estimate& seen) {
  const Eigen::VectorXd column = covariance.col(i);
  const Eigen::VectorXd gain = column / (column(i) + seen.sd * seen.sd);
  values += gain * (seen.value - values(i));
  covariance -= gain * column.transpose();
}

namespace {

constexpr double kAtRest = 1e-100;  ///< m/s

Eigen::Vector2d vector_of(const AlphaV& value) {
  return value.velocity.value * Eigen::Vector2d(std::cos(value.alpha.value), std::sin(value.alpha.value));
}

void require_numbers(const AlphaV& value) {
  for (const double number : {value.alpha.value, value.alpha.sd, value.velocity.value, value.velocity.sd})
    if (!std::isfinite(number)) throw std::invalid_argument("pool_points: a value is no number");
  if (value.alpha.sd < 0 || value.velocity.sd < 0 || value.velocity.value < 0)
    throw std::invalid_argument("pool_points: an sd or a velocity is negative");
}

/// The measurements of a point, and the frame of their plain mean.
struct Point {
  std::vector<AlphaV> values;
  Eigen::Vector2d axis = Eigen::Vector2d::UnitX();  ///< along it
  double speed = 0;                                 ///< of the plain mean

  void find_frame() {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const AlphaV& value : values) sum += vector_of(value);
    speed = sum.norm() / static_cast<double>(values.size());
    const double alpha = values.front().alpha.value;
    axis = speed > 0 ? Eigen::Vector2d(sum.normalized()) : Eigen::Vector2d(std::cos(alpha), std::sin(alpha));
  }
  Eigen::Vector2d normal() const { return {-axis.y(), axis.x()}; }
  Estimate along(const AlphaV& value) const { return {vector_of(value).dot(axis), value.velocity.sd}; }
  Estimate across(const AlphaV& value) const {
    const double v = value.velocity.value;
    return {vector_of(value).dot(normal()), v > 0 ? v * value.alpha.sd : value.velocity.sd};
  }
};
using Coordinate = Estimate (Point::*)(const AlphaV&) const;

/// In one coordinate, of the measurements that `counted` takes.
std::vector<Estimate> coordinates(const Point& point, Coordinate coordinate, const auto& counted) {
  std::vector<Estimate> those;
  for (const AlphaV& value : point.values)
    if (counted(value)) those.push_back((point.*coordinate)(value));
  return those;
}

/// Do the repeats scatter as their sds say?
void test_given_sds(std::vector<Point>& points, PooledPoints& pooled) {
  const auto given = [](const AlphaV& value) { return value.alpha.sd > 0 && value.velocity.sd > 0; };
  for (const Point& point : points)
    for (const Coordinate coordinate : {&Point::along, &Point::across})
      if (const auto repeats = coordinates(point, coordinate, given); repeats.size() > 1) {
        pooled.chi2 += pool(repeats).chi2;
        pooled.chi2_dof += repeats.size() - 1;
      }
  if (pooled.chi2_dof == 0) return;
  const auto dof = static_cast<double>(pooled.chi2_dof);
  pooled.p_value = internal::chi2_survival(pooled.chi2, dof);
  if (pooled.p_value >= kRefusedByChance) return;
  pooled.scattered = std::sqrt(pooled.chi2 / dof);
  for (Point& point : points)
    for (AlphaV& value : point.values) {
      value.alpha.sd *= pooled.scattered;
      value.velocity.sd *= pooled.scattered;
    }
}

/// The scatter of the repeats without an sd in one coordinate of their frames.
RepeatScatter scatter_of(const std::vector<Point>& points, Coordinate coordinate, Estimate AlphaV::*of) {
  double squares = 0, relative_squares = 0, log_speeds = 0;
  RepeatScatter scatter;
  for (const Point& point : points) {
    const auto repeats =
        coordinates(point, coordinate, [of](const AlphaV& value) { return !((value.*of).sd > 0); });
    if (repeats.size() < 2) continue;
    const auto n = static_cast<double>(repeats.size());
    double mean = 0, sum = 0;
    for (const Estimate& e : repeats) mean += e.value / n;
    for (const Estimate& e : repeats) sum += std::pow(e.value - mean, 2);
    squares += sum;
    relative_squares += sum / std::pow(point.speed, 2);
    log_speeds += (n - 1) * std::log(point.speed);
    scatter.dof += repeats.size() - 1;
  }
  if (scatter.dof == 0) return scatter;
  const auto dof = static_cast<double>(scatter.dof);
  scatter.sd = std::sqrt(squares / dof);
  const double share = std::sqrt(relative_squares / dof);
  // -ln L of normal residuals is dof ln s, and of shares dof ln s + sum ln v.
  if (std::isfinite(log_speeds) && share > 0 &&
      dof * std::log(share) + log_speeds < dof * std::log(scatter.sd)) {
    scatter.sd = share;
    scatter.relative = true;
  }
  return scatter;
}

/// One sd for all that have none.
void fill_in_scatter(std::vector<Point>& points, PooledPoints& pooled) {
  pooled.along = scatter_of(points, &Point::along, &AlphaV::velocity);
  pooled.across = scatter_of(points, &Point::across, &AlphaV::alpha);
  const double along =
      pooled.along.dof > 0 ? internal::student_widening(static_cast<double>(pooled.along.dof)) : 1;
  const double across =
      pooled.across.dof > 0 ? internal::student_widening(static_cast<double>(pooled.across.dof)) : 1;
  pooled.widened = std::max(along, across);
  for (Point& point : points) {
    const double speed = along * pooled.along.sd * (pooled.along.relative ? point.speed : 1);
    double angle = pooled.across.sd;
    if (!pooled.across.relative && angle > 0)  // at rest there is no direction, and every one is as good
      angle = point.speed > kAtRest ? std::min(angle / point.speed, std::numbers::pi) : std::numbers::pi;
    for (AlphaV& value : point.values) {
      if (!(value.velocity.sd > 0)) value.velocity.sd = speed;
      if (!(value.alpha.sd > 0)) value.alpha.sd = across * angle;
    }
  }
}

/// The mean of one coordinate, with its sd; plain, without an sd, where one of them has none.
Estimate mean_along(const Point& point, Coordinate coordinate) {
  const auto all = coordinates(point, coordinate, [](const AlphaV&) { return true; });
  const bool known = std::ranges::all_of(all, [](const Estimate& e) { return e.sd > 0; });
  double weights = 0, sum = 0;
  for (const Estimate& e : all) {
    const double weight = known ? 1 / (e.sd * e.sd) : 1;
    weights += weight;
    sum += weight * e.value;
  }
  return {sum / weights, known ? 1 / std::sqrt(weights) : 0};
}

AlphaV mean_of(const Point& point) {
  if (point.values.size() == 1) return point.values.front();
  const Estimate along = mean_along(point, &Point::along), across = mean_along(point, &Point::across);
  const Eigen::Vector2d mean = along.value * point.axis + across.value * point.normal();
  AlphaV result;
  result.velocity = {mean.norm() > kAtRest ? mean.norm() : 0, along.sd};
  const double alpha = std::atan2(mean.y(), mean.x());
  result.alpha.value = alpha < 0 ? alpha + 2 * std::numbers::pi : alpha;
  // At rest there is no direction, and a fit counts the velocity's sd alike in both.
  result.alpha.sd = result.velocity.value > 0 ? across.sd / result.velocity.value : 1;
  return result;
}

}  // namespace

PooledPoints pool_points(std::span<const PointMeasurement> measurements) {
  std::vector<Point> points;
  for (const PointMeasurement& m : measurements) {
    require_numbers(m.value);
    if (m.point >= points.size()) points.resize(m.point + 1);
    points[m.point].values.push_back(m.value);
  }
  for (Point& point : points) {
    if (point.values.empty()) throw std::invalid_argument("pool_points: a point has no measurement");
    point.find_frame();
  }
  PooledPoints pooled;
  test_given_sds(points, pooled);
  fill_in_scatter(points, pooled);
  for (const Point& point : points) pooled.points.push_back(mean_of(point));
  return pooled;
}

}  // namespace tribotrack::fit
