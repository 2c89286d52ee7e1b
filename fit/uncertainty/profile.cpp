#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fit/tools/parallel.h"
#include "fit/uncertainty/profile.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Interval limits(const Unknowns& unknowns, FitParameter parameter, double value) {
  switch (parameter) {
    case FitParameter::mu1:
      return {1e-3 * value, std::max(10.0, 10 * value)};
    case FitParameter::mu2:
      return {1e-5, std::max(10.0, 10 * value)};
    case FitParameter::lag:
      return {value - std::numbers::pi, value + std::numbers::pi};
    case FitParameter::delay:
      return {value - std::numbers::pi / unknowns.reference_frequency(),
              value + std::numbers::pi / unknowns.reference_frequency()};
    case FitParameter::tilt_x:
    case FitParameter::tilt_y:
      return {value - 0.5, value + 0.5};
    default:
      return {0.1 * value, 10 * value};
  }
}

/// The pseudo-inverse of J'J, flat directions left out.
Eigen::MatrixXd spread(const Eigen::MatrixXd& curvature) {
  const Eigen::VectorXd scale = curvature.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * curvature *
                                                             scale.asDiagonal());
  Eigen::VectorXd inverse = eigen.eigenvalues();
  for (double& value : inverse) value = value > 1e-14 ? 1 / value : 0;
  return scale.asDiagonal() * eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose() *
         scale.asDiagonal();
}

class OneSide {
 public:
  OneSide(const Residuals& residuals, const KnownMinimum& best, Eigen::Index parameter, double rise)
      : residuals_(residuals), best_(best), index_(parameter), target_(std::sqrt(rise)) {
    const Eigen::MatrixXd covariance = spread(best.curvature);
    const double variance = covariance(index_, index_);
    sd_ = variance > 0 && std::isfinite(variance) ? std::sqrt(variance) : 1;
    along_ = variance > 0 ? Eigen::VectorXd(covariance.col(index_) / variance)
                          : Eigen::VectorXd(Eigen::VectorXd::Unit(best.minimum.z.size(), index_));
  }

  /// z where the profile crosses; nullopt when it does not before `limit`.
  std::optional<double> cross(double limit) {
    const double direction = limit > best_.minimum.z(index_) ? 1 : -1;
    Point inside{best_.minimum.z, -target_};
    std::optional<Point> outside;
    double step = target_ * sd_;
    for (int i = 0; i < 25; ++i) {
      double z = 0;
      if (outside) {  // regula falsi on sqrt(rise), kept off the ends
        const double share = std::clamp(-inside.height / (outside->height - inside.height), 0.05, 0.95);
        z = inside.z(index_) + share * (outside->z(index_) - inside.z(index_));
      } else {
        z = inside.z(index_) + direction * step;
        if (direction * (z - limit) > 0) z = limit;
      }
      const auto point = at(z, outside && outside->height < -inside.height ? *outside : inside);
      if (better) return std::nullopt;
      if (!point) {  // the model cannot be evaluated there
        step *= 0.5;
        if (outside || step < 1e-3 * sd_) return std::nullopt;
        continue;
      }
      if (std::abs(point->height) < 0.004 * target_) return z;
      if (point->height < 0) {
        if (z == limit) return std::nullopt;
        const double gained = (point->height - inside.height) / std::abs(z - inside.z(index_));
        inside = *point;
        if (!outside)
          step = std::clamp(gained > 0 ? -1.05 * point->height / gained : 4 * step, 0.05 * step, 4 * step);
      } else {
        outside = *point;
      }
      if (outside && std::abs(outside->z(index_) - inside.z(index_)) < 1e-6 * std::max(sd_, 1e-12)) return z;
    }
    return outside ? std::optional(0.5 * (inside.z(index_) + outside->z(index_))) : std::nullopt;
  }

  std::optional<Minimum> better;

 private:
  struct Point {
    Eigen::VectorXd z;
    double height;  ///< sqrt(chi^2 - its minimum) - target
  };

  std::optional<Point> at(double z, const Point& neighbour) {
    const Eigen::VectorXd start = neighbour.z + along_ * (z - neighbour.z(index_));
    MinimiseOptions options;
    options.held = index_;
    options.decrement = 1e-3;
    options.max_iterations = 30;
    const Minimum held = minimise(residuals_, start, options);
    if (!std::isfinite(held.chi2)) return std::nullopt;
    const double rise = held.chi2 - best_.minimum.chi2;
    if (rise < -0.01) better = held;
    return Point{held.z, std::sqrt(std::max(0.0, rise)) - target_};
  }

  const Residuals& residuals_;
  const KnownMinimum& best_;
  Eigen::Index index_;
  double target_, sd_ = 1;
  Eigen::VectorXd along_;
};

}  // namespace

Profile profile(const Residuals& residuals, const KnownMinimum& best, Eigen::Index parameter, double rise) {
  const auto& unknowns = residuals.unknowns();
  const Transform& transform = unknowns.transform(parameter);
  const FitParameter name = unknowns.parameter(parameter);
  const Interval range = limits(unknowns, name, transform.value(best.minimum.z(parameter)));
  const bool may_be_zero = name == FitParameter::mu1 || name == FitParameter::mu2;
  OneSide side(residuals, best, parameter, rise);
  Profile result;
  const auto low = side.cross(transform.z(range.low));
  const auto high = side.better ? std::nullopt : side.cross(transform.z(range.high));
  result.interval.low = low ? transform.value(*low) : may_be_zero ? 0 : -kInfinity;
  result.interval.high = high ? transform.value(*high) : kInfinity;
  result.better = side.better;
  return result;
}

std::vector<Interval> profiles(const Residuals& residuals, KnownMinimum& best, const std::vector<bool>& open,
                               const std::vector<double>& rises, int threads) {
  const auto n = static_cast<std::size_t>(residuals.unknowns().reported());
  Residuals rough = residuals;
  rough.set_tolerance(residuals.tolerance_for(0.01, 1e-6));
  for (int restart = 0;; ++restart) {
    std::vector<Profile> sides(n);
    parallel_for(n, threads, [&](std::size_t i) {
      sides[i].interval = {-kInfinity, kInfinity};
      if (!open[i]) sides[i] = profile(rough, best, static_cast<Eigen::Index>(i), rises[i]);
    });
    const Profile* better = nullptr;
    for (const Profile& side : sides)
      if (side.better && (!better || side.better->chi2 < better->better->chi2)) better = &side;
    if (!better || restart == 3) {
      std::vector<Interval> intervals;
      for (const Profile& side : sides) intervals.push_back(side.interval);
      return intervals;
    }
    best = with_curvature(residuals, minimise(residuals, better->better->z));
  }
}

}  // namespace tribotrack::fit::internal
