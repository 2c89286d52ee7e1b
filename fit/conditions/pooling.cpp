#include "fit/pooling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "fit/tools/statistics.h"

namespace tribotrack::fit {
namespace {

/// Variance of a run's own: without what all share.
double own_variance(const Estimate& value, double common_sd) {
  if (!(value.sd >= 0) || !std::isfinite(value.sd) || !std::isfinite(value.value))
    throw std::invalid_argument("pool: a value or its sd is no number");
  return std::max(0.0, value.sd * value.sd - common_sd * common_sd);
}

/// Exact values: equal to rounding, or refused.
Pooled pool_exact(std::span<const Estimate> exact, double common_sd) {
  Pooled pooled;
  pooled.count = exact.size();
  pooled.mean = {exact.front().value, common_sd};
  for (const Estimate& e : exact)
    if (std::abs(e.value - pooled.mean.value) > 1e-12 * std::abs(pooled.mean.value)) {
      pooled.chi2 = std::numeric_limits<double>::infinity();
      pooled.p_value = 0;
    }
  return pooled;
}

}  // namespace

Pooled pool(std::span<const Estimate> values, double common_sd) {
  if (values.empty()) throw std::invalid_argument("pool: no value");
  std::vector<double> variances;
  std::vector<Estimate> exact;
  for (const Estimate& value : values) {
    variances.push_back(own_variance(value, common_sd));
    if (variances.back() == 0) exact.push_back(value);
  }
  if (!exact.empty()) return pool_exact(exact, common_sd);

  double weights = 0, sum = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    weights += 1 / variances[k];
    sum += values[k].value / variances[k];
  }
  Pooled pooled;
  pooled.count = values.size();
  pooled.mean.value = sum / weights;
  pooled.own_sd = std::sqrt(1 / weights);
  for (std::size_t k = 0; k < values.size(); ++k)
    pooled.chi2 += std::pow(values[k].value - pooled.mean.value, 2) / variances[k];
  const double dof = static_cast<double>(values.size()) - 1;
  pooled.p_value = internal::chi2_survival(pooled.chi2, dof);
  if (!pooled.one_value()) pooled.own_sd *= std::sqrt(pooled.chi2 / dof);
  pooled.mean.sd = std::hypot(pooled.own_sd, common_sd);
  return pooled;
}

Pooled pool_angles(std::span<const Estimate> values, double common_sd) {
  if (values.empty()) throw std::invalid_argument("pool: no value");
  const double first = values.front().value;
  std::vector<Estimate> differences;
  for (const Estimate& angle : values)
    differences.push_back({std::remainder(angle.value - first, 2 * std::numbers::pi), angle.sd});
  Pooled pooled = pool(differences, common_sd);
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

/// Student's 95 % quantile over the normal one.
double student_widening(std::size_t dof) {
  constexpr double kLevel = 0.95;
  return internal::two_sided_quantile(kLevel, static_cast<double>(dof)) /
         internal::two_sided_quantile(kLevel, std::numeric_limits<double>::infinity());
}

/// A point's measurements in the frame of their plain mean: along it and across it.
struct Frame {
  Eigen::Vector2d along = Eigen::Vector2d::UnitX();
  double speed = 0;  ///< of the plain mean
  Eigen::Vector2d across() const { return {-along.y(), along.x()}; }
};

Eigen::Vector2d vector_of(const AlphaV& value) {
  return value.velocity.value * Eigen::Vector2d(std::cos(value.alpha.value), std::sin(value.alpha.value));
}

void require_numbers(const AlphaV& value) {
  for (const double number : {value.alpha.value, value.alpha.sd, value.velocity.value, value.velocity.sd})
    if (!std::isfinite(number)) throw std::invalid_argument("pool_points: a value is no number");
  if (value.alpha.sd < 0 || value.velocity.sd < 0 || value.velocity.value < 0)
    throw std::invalid_argument("pool_points: an sd or a velocity is negative");
}

class Pooling {
 public:
  explicit Pooling(std::span<const PointMeasurement> measurements)
      : all_(measurements.begin(), measurements.end()) {
    for (const PointMeasurement& m : all_) {
      require_numbers(m.value);
      if (m.point >= members_.size()) members_.resize(m.point + 1);
      members_[m.point].push_back(static_cast<std::size_t>(&m - all_.data()));
    }
    for (const auto& members : members_) {
      if (members.empty()) throw std::invalid_argument("pool_points: a point has no measurement");
      frames_.push_back(frame_of(members));
    }
  }

  PooledPoints run() {
    PooledPoints pooled;
    test_given_sds(pooled);
    fill_in_scatter(pooled);
    for (std::size_t p = 0; p < members_.size(); ++p) pooled.points.push_back(mean_of(p));
    return pooled;
  }

 private:
  Frame frame_of(const std::vector<std::size_t>& members) const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const std::size_t k : members) sum += vector_of(all_[k].value);
    Frame frame;
    frame.speed = sum.norm() / static_cast<double>(members.size());
    const double alpha = all_[members.front()].value.alpha.value;
    frame.along = frame.speed > 0 ? Eigen::Vector2d(sum.normalized())
                                  : Eigen::Vector2d(std::cos(alpha), std::sin(alpha));
    return frame;
  }

  /// Squares of what `off` says of the repeats of points measured more than once, and their degrees of
  /// freedom, over the measurements that `counted` takes.
  template <typename Off, typename Counted>
  std::pair<double, std::size_t> squares(const Off& off, const Counted& counted) const {
    double sum = 0;
    std::size_t dof = 0;
    for (std::size_t p = 0; p < members_.size(); ++p) {
      std::vector<double> values, weights;
      for (const std::size_t k : members_[p])
        if (counted(all_[k].value)) {
          const auto [value, weight] = off(all_[k].value, frames_[p]);
          values.push_back(value);
          weights.push_back(weight);
        }
      if (values.size() < 2) continue;
      double total = 0, mean = 0;
      for (std::size_t i = 0; i < values.size(); ++i) {
        total += weights[i];
        mean += weights[i] * values[i];
      }
      mean /= total;
      for (std::size_t i = 0; i < values.size(); ++i) sum += weights[i] * std::pow(values[i] - mean, 2);
      dof += values.size() - 1;
    }
    return {sum, dof};
  }

  static double across_sd(const AlphaV& value) {
    return value.velocity.value > 0 ? value.velocity.value * value.alpha.sd : value.velocity.sd;
  }

  /// Do the repeats scatter as their sds say?
  void test_given_sds(PooledPoints& pooled) {
    const auto given = [](const AlphaV& value) { return value.alpha.sd > 0 && value.velocity.sd > 0; };
    const auto [along, dof] = squares(
        [](const AlphaV& value, const Frame& frame) {
          return std::pair(vector_of(value).dot(frame.along), std::pow(value.velocity.sd, -2));
        },
        given);
    const auto [across, dof_across] = squares(
        [](const AlphaV& value, const Frame& frame) {
          return std::pair(vector_of(value).dot(frame.across()), std::pow(across_sd(value), -2));
        },
        given);
    pooled.chi2 = along + across;
    pooled.chi2_dof = dof + dof_across;
    if (pooled.chi2_dof == 0) return;
    pooled.p_value = internal::chi2_survival(pooled.chi2, static_cast<double>(pooled.chi2_dof));
    if (pooled.p_value >= kRefusedByChance) return;
    pooled.scattered = std::sqrt(pooled.chi2 / static_cast<double>(pooled.chi2_dof));
    for (PointMeasurement& m : all_) {
      m.value.alpha.sd *= pooled.scattered;
      m.value.velocity.sd *= pooled.scattered;
    }
  }

  /// The scatter of the repeats without an sd in one coordinate of their frames.
  template <typename Off, typename Counted>
  RepeatScatter scatter_of(const Off& off, const Counted& counted) const {
    double squares = 0, relative_squares = 0, log_speeds = 0;
    RepeatScatter scatter;
    for (std::size_t p = 0; p < members_.size(); ++p) {
      std::vector<double> values;
      for (const std::size_t k : members_[p])
        if (counted(all_[k].value)) values.push_back(off(all_[k].value, frames_[p]));
      if (values.size() < 2) continue;
      const auto n = static_cast<double>(values.size());
      double mean = 0, sum = 0;
      for (const double value : values) mean += value / n;
      for (const double value : values) sum += std::pow(value - mean, 2);
      squares += sum;
      relative_squares += sum / std::pow(frames_[p].speed, 2);
      log_speeds += (n - 1) * std::log(frames_[p].speed);
      scatter.dof += values.size() - 1;
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
  void fill_in_scatter(PooledPoints& pooled) {
    pooled.along =
        scatter_of([](const AlphaV& value, const Frame& frame) { return vector_of(value).dot(frame.along); },
                   [](const AlphaV& value) { return !(value.velocity.sd > 0); });
    pooled.across = scatter_of(
        [](const AlphaV& value, const Frame& frame) { return vector_of(value).dot(frame.across()); },
        [](const AlphaV& value) { return !(value.alpha.sd > 0); });
    const double along = pooled.along.dof > 0 ? student_widening(pooled.along.dof) : 1;
    const double across = pooled.across.dof > 0 ? student_widening(pooled.across.dof) : 1;
    pooled.widened = std::max(along, across);
    for (PointMeasurement& m : all_) {
      const double speed = frames_[m.point].speed;
      if (!(m.value.velocity.sd > 0))
        m.value.velocity.sd = along * pooled.along.sd * (pooled.along.relative ? speed : 1);
      if (!(m.value.alpha.sd > 0)) m.value.alpha.sd = across * angle_of(pooled.across, speed);
    }
  }

  /// At rest there is no direction, and every one is as good.
  static double angle_of(const RepeatScatter& across, double speed) {
    if (across.relative || across.sd == 0) return across.sd;
    return speed > kAtRest ? std::min(across.sd / speed, std::numbers::pi) : std::numbers::pi;
  }

  /// One coordinate of the mean, with its sd; plain, without an sd, where one of them has none.
  static Estimate weighted(const std::vector<Estimate>& values) {
    const bool known = std::ranges::all_of(values, [](const Estimate& e) { return e.sd > 0; });
    double weights = 0, sum = 0;
    for (const Estimate& e : values) {
      const double weight = known ? 1 / (e.sd * e.sd) : 1;
      weights += weight;
      sum += weight * e.value;
    }
    return {sum / weights, known ? 1 / std::sqrt(weights) : 0};
  }

  AlphaV mean_of(std::size_t point) const {
    const std::vector<std::size_t>& members = members_[point];
    if (members.size() == 1) return all_[members.front()].value;
    const Frame& frame = frames_[point];
    std::vector<Estimate> along, across;
    for (const std::size_t k : members) {
      const AlphaV& value = all_[k].value;
      along.push_back({vector_of(value).dot(frame.along), value.velocity.sd});
      across.push_back({vector_of(value).dot(frame.across()), across_sd(value)});
    }
    const Estimate a = weighted(along), c = weighted(across);
    const Eigen::Vector2d mean = a.value * frame.along + c.value * frame.across();
    AlphaV result;
    result.velocity = {mean.norm() > kAtRest ? mean.norm() : 0, a.sd};
    const double alpha = std::atan2(mean.y(), mean.x());
    result.alpha.value = alpha < 0 ? alpha + 2 * std::numbers::pi : alpha;
    // At rest there is no direction, and a fit counts the velocity's sd alike in both.
    result.alpha.sd = result.velocity.value > 0 ? c.sd / result.velocity.value : 1;
    return result;
  }

  std::vector<PointMeasurement> all_;
  std::vector<std::vector<std::size_t>> members_;
  std::vector<Frame> frames_;
};

}  // namespace

PooledPoints pool_points(std::span<const PointMeasurement> measurements) {
  return Pooling(measurements).run();
}

}  // namespace tribotrack::fit
