#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "fit/estimate.h"
#include "fit/measurement.h"

namespace tribotrack::fit {
namespace {

/// A part on a platform of 10 Hz, carried along and sliding by turns: its acceleration jumps at each change.
struct Film {
  std::vector<std::int64_t> frames;
  std::vector<Eigen::Vector2d> positions;
};

Film film(double rate, std::size_t count, double sd_x, double sd_y, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Film film;
  double slid = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double t = static_cast<double>(k) / rate, turn = 62.8 * t;
    slid += 5 * std::max(0.0, std::sin(turn)) / rate;
    film.frames.push_back(static_cast<std::int64_t>(k));
    film.positions.emplace_back(0.28 * std::cos(turn) + slid + sd_x * normal(random),
                                -0.28 * std::sin(turn) - 0.5 * slid + sd_y * normal(random));
  }
  return film;
}

TEST(PointNoise, IsTheScatterOfEachCoordinate) {
  for (const double rate : {250.0, 500.0, 1000.0}) {
    const Film f = film(rate, 1000, 0.003, 0.006, 5);
    const auto noise = point_noise(f.frames, f.positions);
    ASSERT_TRUE(noise) << rate;
    EXPECT_NEAR(noise->sd.x() / 0.003, 1, 0.12) << rate;
    EXPECT_NEAR(noise->sd.y() / 0.006, 1, 0.12) << rate;
  }
}

TEST(PointNoise, WithFewFramesToATurnItIsTooLargeRatherThanTooSmall) {
  const Film f = film(100, 1000, 0.003, 0.006, 5);
  const auto noise = point_noise(f.frames, f.positions);
  ASSERT_TRUE(noise);
  EXPECT_GT(noise->sd.x() / 0.003, 0.88);
  EXPECT_LT(noise->sd.x() / 0.003, 2);
}

TEST(PointNoise, LostFramesAndEverySecondFrameDoNotMatter) {
  const Film f = film(500, 2000, 0.004, 0.004, 6);
  Film kept;
  for (std::size_t k = 0; k < f.frames.size(); k += 2) {
    if (k % 200 == 0) continue;
    kept.frames.push_back(f.frames[k]);
    kept.positions.push_back(f.positions[k]);
  }
  const auto noise = point_noise(kept.frames, kept.positions);
  ASSERT_TRUE(noise);
  EXPECT_NEAR(noise->sd.x() / 0.004, 1, 0.12);
}

/// A slide along x, `colour` the correlation of its errors from frame to frame.
TrajectoryRun slide(std::size_t count, double sd, double colour, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  TrajectoryRun run;
  run.free_slide = true;
  run.scenario.drive.amplitude = run.scenario.drive.amplitude_y = 0;
  Eigen::Vector2d error = Eigen::Vector2d::Zero();
  const double end = 0.3, speed = 0.6;
  for (std::size_t k = 0; k < count; ++k) {
    const double t = end * static_cast<double>(k) / static_cast<double>(count);
    const double fresh = k == 0 ? 1 : std::sqrt(1 - colour * colour);
    error = colour * error + fresh * sd * Eigen::Vector2d(normal(random), normal(random));
    run.track.frame.push_back(static_cast<std::int64_t>(k));
    run.track.time.push_back(t);
    run.track.position.emplace_back(Eigen::Vector2d(speed * t - 0.5 * speed / end * t * t, 0) + error);
  }
  const auto noise = point_noise(run.track.frame, run.track.position);
  run.track.noise_dof = noise->dof;
  run.track.covariance.assign(count, noise->sd.cwiseAbs2().asDiagonal());
  return run;
}

double p_of(const TrajectoryRun& slide) {
  Problem problem;
  problem.free = {FitParameter::mu1};
  problem.trajectory_runs = {slide};
  FitOptions quick{.multi_starts = 1, .profiles = false, .next_experiment = false, .estimate_scatter = false};
  return estimate(problem, quick).p_value;
}

// 95 of 100 within three sds of a binomial share: the noise is estimated from the points that it judges.
TEST(PointNoise, PerfectWhiteNoiseIsAccepted) {
  std::mt19937_64 random(8);
  constexpr int kTracks = 400;
  constexpr std::size_t kLengths[] = {36, 60, 120, 300};
  int accepted = 0, doubted = 0;
  for (int k = 0; k < kTracks; ++k) {
    const double p = p_of(slide(kLengths[k % 4], 3e-5, 0, random));
    accepted += p > 0.05;
    doubted += p < 1e-3;
  }
  EXPECT_NEAR(accepted, 0.95 * kTracks, 3 * std::sqrt(0.95 * 0.05 * kTracks));
  EXPECT_LE(doubted, 4);
}

TEST(PointNoise, ColouredNoiseIsNot) {
  std::mt19937_64 random(10);
  for (int k = 0; k < 10; ++k) EXPECT_LT(p_of(slide(200, 3e-5, 0.8, random)), 1e-3);
}

TEST(PointNoise, TooFewFramesTellNothing) {
  const Film f = film(250, 29, 0.003, 0.003, 7);
  EXPECT_FALSE(point_noise(f.frames, f.positions));
  EXPECT_FALSE(point_noise({}, {}));
}

}  // namespace
}  // namespace tribotrack::fit
