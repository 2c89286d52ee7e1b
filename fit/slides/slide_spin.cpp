#include "fit/slides/slide_spin.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <vector>

#include "fit/residuals/free_slide.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

constexpr std::size_t kFewestAngles = 8;
constexpr double kEvenDisc = 0.5;  ///< k
constexpr double kSpread = 0.35;   ///< sd of ln k: a factor of two at two sd
constexpr int kRounds = 30;

/// The angles seen, without jumps by whole turns.
struct Angles {
  std::vector<double> time, angle, sigma;  ///< time from the first point of the slide
};

Angles angles_of(const TrackTable& track, std::size_t first) {
  Angles seen;
  for (std::size_t i = first; i < track.time.size() && i < track.angle.size(); ++i) {
    if (!std::isfinite(track.angle[i]) || !(track.angle_sigma[i] > 0)) continue;
    const double time = track.time[i] - track.time[first];
    const double angle =
        seen.angle.empty()
            ? track.angle[i]
            : seen.angle.back() + std::remainder(track.angle[i] - seen.angle.back(), 2 * std::numbers::pi);
    seen.time.push_back(time);
    seen.angle.push_back(angle);
    seen.sigma.push_back(track.angle_sigma[i]);
  }
  return seen;
}

/// Straight line through the first angles: where the search begins.
double first_rate(const Angles& seen) {
  const auto n = static_cast<Eigen::Index>(std::max(kFewestAngles / 2, seen.time.size() / 4));
  Eigen::MatrixX2d a(n, 2);
  Eigen::VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a.row(i) << 1, seen.time[static_cast<std::size_t>(i)];
    b(i) = seen.angle[static_cast<std::size_t>(i)];
  }
  return a.colPivHouseholderQr().solve(b)(1);
}

class SpinFit {
 public:
  SpinFit(const Angles& seen, const model::Scenario& scenario) : seen_(seen), scenario_(scenario) {}

  /// Residuals over their sds, the prior of ln k last; `at` = (theta_0, omega, ln k).
  Eigen::VectorXd residuals(const Eigen::Vector3d& at) const {
    model::Scenario scenario = scenario_;
    scenario.spin.rate = at(1);
    scenario.spin.inertia = std::exp(at(2));
    const model::Trajectory run = model::integrate(scenario, {.tolerance = 1e-10, .derivatives = {}});
    const std::size_t n = seen_.time.size();
    Eigen::VectorXd r(static_cast<Eigen::Index>(n) + 1);
    for (std::size_t i = 0; i < n; ++i)
      r(static_cast<Eigen::Index>(i)) =
          (at(0) + run.at(seen_.time[i]).angle - seen_.angle[i]) / seen_.sigma[i];
    r(r.size() - 1) = (at(2) - std::log(kEvenDisc)) / kSpread;
    return r;
  }
  Eigen::MatrixX3d jacobian(const Eigen::Vector3d& at) const {
    const Eigen::Vector3d steps(1e-4, 1e-4 * std::max(1.0, std::abs(at(1))), 1e-4);
    Eigen::MatrixX3d result(static_cast<Eigen::Index>(seen_.time.size()) + 1, 3);
    for (Eigen::Index j = 0; j < 3; ++j) {
      const Eigen::Vector3d step = steps(j) * Eigen::Vector3d::Unit(j);
      result.col(j) = (residuals(at + step) - residuals(at - step)) / (2 * steps(j));
    }
    return result;
  }

 private:
  const Angles& seen_;
  model::Scenario scenario_;
};

}  // namespace

std::optional<DiscSpin> slide_spin(const TrajectoryRun& run, double mu, const Eigen::Vector2d& velocity) {
  if (run.track.angle.empty() || !(run.track.radius > 0)) return std::nullopt;
  const Angles seen = angles_of(run.track, guess_free_slide(run).first);
  if (seen.time.size() < kFewestAngles) return std::nullopt;

  model::Scenario scenario;
  scenario.drive.amplitude = scenario.drive.amplitude_y = 0;
  scenario.drive.gravity = run.scenario.drive.gravity;
  scenario.friction = {mu, 0, 0, 0, 0};
  scenario.initial_velocity = velocity;
  scenario.spin.radius = run.track.radius;
  scenario.duration = seen.time.back();
  const SpinFit fit(seen, scenario);

  Eigen::Vector3d at(seen.angle.front(), first_rate(seen), std::log(kEvenDisc));
  Eigen::VectorXd r = fit.residuals(at);
  Eigen::MatrixX3d jacobian = fit.jacobian(at);
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Vector3d step = jacobian.colPivHouseholderQr().solve(-r);
    double share = 1;
    Eigen::VectorXd there = fit.residuals(at + step);
    while (!(there.squaredNorm() <= r.squaredNorm()) && share > 1e-4) {
      share /= 2;
      there = fit.residuals(at + share * step);
    }
    const double gained = r.squaredNorm() - there.squaredNorm();
    if (!(gained >= 0)) break;
    at += share * step;
    r = there;
    jacobian = fit.jacobian(at);
    if (gained < 1e-6 * (1 + r.squaredNorm())) break;
  }
  const Eigen::Matrix3d covariance = (jacobian.transpose() * jacobian).inverse();
  const double dof = static_cast<double>(seen.time.size()) - 2;
  const double excess = std::max(1.0, r.squaredNorm() / dof);
  return DiscSpin{{at(1), std::sqrt(excess * covariance(1, 1))}, std::exp(at(2))};
}

std::optional<DiscSpin> first_slide_spin(const TrajectoryRun& run) {
  const FreeSlideGuess guess = guess_free_slide(run);
  return slide_spin(run, guess.mu, guess.velocity);
}

}  // namespace tribotrack::fit::internal
