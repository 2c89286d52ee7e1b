// Campaigns that are fitted point by point.
#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <string>

#include "apps/bench/fit/designs.h"
#include "apps/bench/fit/information.h"
#include "apps/bench/peers/baselines.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

using Eigen::Vector2d;
using std::numbers::pi;

constexpr double kFrameRate = 240;  ///< Hz

void add_point(TrackTable& track, double time, const Vector2d& position, double sigma) {
  track.frame.push_back(static_cast<std::int64_t>(track.time.size()));
  track.time.push_back(time);
  track.position.push_back(position);
  track.covariance.push_back(sigma * sigma * Eigen::Matrix2d::Identity());
}

/// A slide without spin: s = v t - mu g t^2/2 until it stops.
struct Parabola {
  double mu, speed, gravity;
  double stop() const { return speed / (mu * gravity); }
  double way(double t) const {
    t = std::min(t, stop());
    return speed * t - 0.5 * mu * gravity * t * t;
  }
  /// By start point, speed and mu.
  Eigen::RowVector3d slopes(double t) const {
    t = std::min(t, stop());
    return {1, t, -0.5 * gravity * t * t};
  }
};

/// Per axis, m: of a straight drift and of a Brownian walk over the track, of cos and sin of wt, and of 2wt
/// and 3wt.
struct SlowErrors {
  double drift, walk, circle, overtones;

  Eigen::MatrixXd basis(const std::vector<double>& times, double w) const {
    const auto n = static_cast<Eigen::Index>(times.size());
    Eigen::MatrixXd basis(n, 7 + n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double t = times[static_cast<std::size_t>(i)];
      basis(i, 0) = drift * t / times.back();
      for (int order = 1; order <= 3; ++order) {
        const double size = order == 1 ? circle : overtones;
        basis(i, 2 * order - 1) = size * std::cos(order * w * t);
        basis(i, 2 * order) = size * std::sin(order * w * t);
      }
      for (Eigen::Index j = 0; j < n; ++j)
        basis(i, 7 + j) = j > 0 && j <= i ? walk / std::sqrt(static_cast<double>(n - 1)) : 0;
    }
    return basis;
  }
};

/// Positions by the peer's integrator, which knows end points only.
Eigen::Matrix2Xd from_point_to_point(const model::Scenario& scenario, const std::vector<double>& times) {
  Eigen::Matrix2Xd positions = Eigen::Matrix2Xd::Zero(2, static_cast<Eigen::Index>(times.size()));
  model::Scenario piece = scenario;
  for (std::size_t i = 1; i < times.size(); ++i) {
    piece.start_phase = scenario.start_phase + scenario.drive.angular_frequency * times[i - 1];
    piece.duration = times[i] - times[i - 1];
    DormandPrinceOptions options = segmented_dormand_prince(piece, 1e-9);
    options.max_steps = 100'000;
    const PeerResult end = dormand_prince(piece, options);
    if (!end.finished) throw PeerHangs();
    piece.initial_velocity = end.velocity;
    const auto k = static_cast<Eigen::Index>(i);
    positions.col(k) = positions.col(k - 1) + end.position;
  }
  return positions;
}

}  // namespace

CoverageCampaign draw_slides(NoiseLevel level, Dice& dice) {
  const bool low = level == NoiseLevel::low;
  const double sigma = low ? 20e-6 : 60e-6, between = low ? 0.01 : 0.04;
  CoverageCampaign campaign;
  campaign.problem.free = {FitParameter::mu1};
  const double mu1 = dice.uniform(0.1, 0.25);
  campaign.truth = {mu1};
  const int count = static_cast<int>(dice.uniform(3, 9));
  double information = 0;
  for (int k = 0; k < count; ++k) {
    TrajectoryRun run;
    run.name = "slide" + std::to_string(k + 1);
    run.free_slide = true;
    run.scenario.drive.amplitude = run.scenario.drive.amplitude_y = 0;
    run.track.radius = 15.5e-3;
    const Parabola slide{mu1 * (1 + between * dice.normal()), dice.uniform(0.4, 0.8),
                         run.scenario.drive.gravity};
    const double angle = dice.uniform(0, 2 * pi);
    const Vector2d way(std::cos(angle), std::sin(angle));
    Eigen::Matrix3d known = Eigen::Matrix3d::Zero();
    for (int i = 0; i / kFrameRate < slide.stop() + 0.05; ++i) {
      const double t = i / kFrameRate;
      add_point(run.track, t, slide.way(t) * way + sigma * dice.normal_pair(), sigma);
      known += slide.slopes(t).transpose() * slide.slopes(t) / (sigma * sigma);
    }
    information += 1 / (known.inverse()(2, 2) + between * between * mu1 * mu1);
    campaign.problem.trajectory_runs.push_back(run);
  }
  campaign.bound = {1 / std::sqrt(information)};
  return campaign;
}

CoverageCampaign draw_trajectories(NoiseLevel level, const model::Scenario& truth, Dice& dice) {
  constexpr int kRuns = 4;
  constexpr double kCycles = 6;
  const double up = level == NoiseLevel::low ? 1 : 4;
  const double sigma = up * dice.log_uniform(1e-6, 4e-6);
  const auto slow_size = [&] { return up * dice.log_uniform(2e-6, 10e-6); };
  const double drift = slow_size(), walk = slow_size(), circle = slow_size(), overtones = slow_size();
  const SlowErrors slow{drift, walk, circle, overtones};
  CoverageCampaign campaign;
  campaign.problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  campaign.truth = {truth.friction.nominal, truth.friction.reduced, truth.friction.lag};
  std::vector<double> times;
  for (int i = 0; i / kFrameRate <= kCycles * 2 * pi / truth.drive.angular_frequency; ++i)
    times.push_back(i / kFrameRate);
  const auto points = static_cast<Eigen::Index>(times.size());
  const Eigen::MatrixXd basis = slow.basis(times, truth.drive.angular_frequency);
  std::vector<model::Scenario> runs;
  for (int k = 0; k < kRuns; ++k) {
    model::Scenario scenario = truth;
    scenario.friction.phase = dice.uniform(0, 2 * pi);
    scenario.friction.pulse_width = dice.uniform(0.5, pi);
    scenario.duration = times.back();
    runs.push_back(scenario);
    TrajectoryRun run;
    run.name = "run" + std::to_string(k + 1);
    run.scenario = scenario;
    run.scenario.friction.nominal = run.scenario.friction.reduced = 0.05;
    run.scenario.friction.lag = 0;
    run.track.platform_frame = true;
    Eigen::Matrix2Xd seen = from_point_to_point(scenario, times);
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      Eigen::VectorXd drawn(basis.cols());
      for (double& value : drawn) value = dice.normal();
      seen.row(axis) += (basis * drawn).transpose();
    }
    for (std::size_t i = 0; i < times.size(); ++i)
      add_point(run.track, times[i], seen.col(static_cast<Eigen::Index>(i)) + sigma * dice.normal_pair(),
                sigma);
    campaign.problem.trajectory_runs.push_back(run);
  }
  // The start point is unknown: as an error common to all points, and far larger than any other.
  const Eigen::MatrixXd covariance = basis * basis.transpose() +
                                     sigma * sigma * Eigen::MatrixXd::Identity(points, points) +
                                     1e-6 * Eigen::MatrixXd::Ones(points, points);
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  const std::vector<Unknown> unknowns{
      {[](model::Scenario& s, double by) { s.friction.nominal += by; }, 1e-5 * truth.friction.nominal},
      {[](model::Scenario& s, double by) { s.friction.reduced += by; }, 1e-5 * truth.friction.reduced},
      {[](model::Scenario& s, double by) { s.friction.lag += by; }, 1e-5}};
  campaign.bound = cramer_rao(runs, unknowns, 3, [&](std::size_t, const model::Scenario& scenario) {
    Eigen::Matrix2Xd positions;
    model::integrate(scenario).positions_at(times, 0, positions, nullptr);
    const Eigen::MatrixXd whitened = factor.matrixL().solve(positions.transpose());
    return Eigen::VectorXd(whitened.reshaped());
  });
  return campaign;
}

}  // namespace tribotrack::bench
