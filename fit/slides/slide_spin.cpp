#include "fit/slides/slide_spin.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "fit/residuals/free_slide.h"
#include "fit/tools/dense.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

constexpr std::size_t kFewestAngles = 8;
/// Known beforehand of the bearing: all of the face, sd of its logarithm a factor of two. Where the part
/// spins enough to matter the angles know it to some per cent, and a prior half or twice as wide changes
/// nothing.
constexpr double kWholeFace = 0, kSpread = 0.7;
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
  return least_squares(a, b)(1);
}

struct Linearised {
  Eigen::VectorXd residuals;  ///< over their sds, the prior of the bearing last
  Eigen::MatrixX3d jacobian;  ///< by theta_0, omega, bearing
};

Linearised residuals_at(const Angles& seen, model::Scenario scenario, const Eigen::Vector3d& at) {
  const double share = std::exp(at(2));
  const double inertia = 0.5 / (share * share);
  scenario.spin = {at(1), scenario.spin.radius * share, inertia};
  const model::Trajectory run = model::integrate(
      scenario, {.tolerance = 1e-10, .derivatives = {model::Parameter::spin, model::Parameter::inertia}});
  const auto n = static_cast<Eigen::Index>(seen.time.size());
  Linearised result{Eigen::VectorXd(n + 1), Eigen::MatrixX3d(n + 1, 3)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const model::SensitiveSample there = run.sensitive_at(seen.time[k]);
    const double angle = there.sample.angle, by_rate = there.angle_jacobian(0);
    result.residuals(i) = (at(0) + angle - seen.angle[k]) / seen.sigma[k];
    // theta = way of the bearing rim/radius: by ln radius through omega R, through k and directly.
    result.jacobian.row(i) << 1, by_rate, at(1) * by_rate - angle - 2 * inertia * there.angle_jacobian(1);
    result.jacobian.row(i) /= seen.sigma[k];
  }
  result.residuals(n) = (at(2) - kWholeFace) / kSpread;
  result.jacobian.row(n) << 0, 0, 1 / kSpread;
  return result;
}

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

  Eigen::Vector3d at(seen.angle.front(), first_rate(seen), kWholeFace);
  Linearised here = residuals_at(seen, scenario, at);
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Vector3d step = least_squares(here.jacobian, -here.residuals);
    double share = 1;
    Linearised there = residuals_at(seen, scenario, at + step);
    while (!(there.residuals.squaredNorm() <= here.residuals.squaredNorm()) && share > 1e-4) {
      share /= 2;
      there = residuals_at(seen, scenario, at + share * step);
    }
    const double gained = here.residuals.squaredNorm() - there.residuals.squaredNorm();
    if (!(gained >= 0)) break;
    at += share * step;
    here = std::move(there);
    if (gained < 1e-6 * (1 + here.residuals.squaredNorm())) break;
  }
  const Eigen::Matrix3d covariance = (here.jacobian.transpose() * here.jacobian).inverse();
  const double dof = static_cast<double>(seen.time.size()) - 2;
  const double excess = std::max(1.0, here.residuals.squaredNorm() / dof);
  return DiscSpin{at(1), at(2), excess * covariance.bottomRightCorner<2, 2>()};
}

std::optional<DiscSpin> first_slide_spin(const TrajectoryRun& run) {
  const FreeSlideGuess guess = guess_free_slide(run);
  return slide_spin(run, guess.mu, guess.velocity);
}

}  // namespace tribotrack::fit::internal
