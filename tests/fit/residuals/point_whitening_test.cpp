// Whitening of white noise and slow errors against the dense covariance of all points.
#include "fit/residuals/track_whitening.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <random>

#include "fit/tools/track_errors.h"

namespace tribotrack::fit::internal {
namespace {

// Points at uneven times, of unequal and correlated axes, some known better than the slow errors say.
TrackTable track_of(int n, const std::vector<SlowError>& slow, std::mt19937& random) {
  std::uniform_real_distribution<double> sigma(0.7, 2), step(0.2, 3);
  TrackTable track;
  track.slow = slow;
  double time = 0;
  for (int k = 0; k < n; ++k) {
    const double a = sigma(random), b = sigma(random), off = 0.4 * a * b;
    track.time.push_back(time += step(random));
    track.position.emplace_back(0, 0);
    track.covariance.push_back((Eigen::Matrix2d() << a * a, off, off, b * b).finished());
  }
  return track;
}

PointWhitening whitening_of(const TrackTable& track) {
  std::vector<Eigen::Matrix2d> own;
  std::vector<double> share;
  for (std::size_t i = 0; i < track.time.size(); ++i) {
    const PointErrors errors = point_errors(track, i);
    own.push_back(errors.own + 1e-6 * Eigen::Matrix2d::Identity());
    share.push_back(errors.slow);
  }
  return {track.time, own, share, track.slow};
}

/// By its definition in fit/tools/track_errors.h: rows (x, y) of one point below the other.
Eigen::MatrixXd dense(const TrackTable& track) {
  const auto n = static_cast<Eigen::Index>(track.time.size());
  Eigen::MatrixXd v(2 * n, 2 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      const PointErrors first = point_errors(track, a), second = point_errors(track, b);
      double slow = 0;
      for (const SlowError& s : track.slow)
        slow += s.sd * s.sd * std::exp(-std::abs(track.time[a] - track.time[b]) / s.time);
      v.block<2, 2>(2 * i, 2 * j) = first.slow * second.slow * slow * Eigen::Matrix2d::Identity();
      if (i == j) v.block<2, 2>(2 * i, 2 * i) += first.own + 1e-6 * Eigen::Matrix2d::Identity();
    }
  return v;
}

const std::vector<std::vector<SlowError>> kSlow{
    {}, {{0.8, 4}}, {{0.5, 0.3}, {0.3, 50}, {0.2, 1e4}}, {{0, 1}, {3, 20}}};

TEST(PointWhitening, IsCholeskysOfTheDenseCovariance) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (const auto& slow : kSlow) {
    const TrackTable track = track_of(60, slow, random);
    const PointWhitening whitening = whitening_of(track);
    const Eigen::LLT<Eigen::MatrixXd> factor(dense(track));
    Eigen::VectorXd column(120);
    for (double& value : column) value = normal(random);
    const Eigen::VectorXd expected = factor.matrixL().solve(column);
    Eigen::VectorXd found = column;
    whitening.apply(found);
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff());
  }
}

// Of what a sum of whitened rows scatters by, the part of the points' own noise.
TEST(PointWhitening, TakesTheOwnNoiseOutOfASum) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (const auto& slow : kSlow) {
    const TrackTable track = track_of(40, slow, random);
    const PointWhitening whitening = whitening_of(track);
    const Eigen::LLT<Eigen::MatrixXd> factor(dense(track));
    Eigen::VectorXd sum(80);
    for (double& value : sum) value = normal(random);
    const Eigen::VectorXd by_point = factor.matrixU().solve(sum);
    double expected = 0;
    for (std::size_t i = 0; i < track.time.size(); ++i) {
      const Eigen::Vector2d h = by_point.segment<2>(2 * static_cast<Eigen::Index>(i));
      expected += h.dot((point_errors(track, i).own + 1e-6 * Eigen::Matrix2d::Identity()) * h);
    }
    whitening.take_own(sum);
    EXPECT_NEAR(sum.squaredNorm(), expected, 1e-11 * expected);
  }
}

// The sum of both is what the table says of each point, and nobody's own noise is negative.
TEST(TrackErrors, AddUpToThePointsOwnCovariance) {
  std::mt19937 random(8);
  for (const auto& slow : kSlow) {
    const TrackTable track = track_of(40, slow, random);
    for (std::size_t i = 0; i < track.time.size(); ++i) {
      const PointErrors errors = point_errors(track, i);
      double variance = 0;
      for (const SlowError& s : slow) variance += errors.slow * errors.slow * s.sd * s.sd;
      const Eigen::Matrix2d sum = errors.own + variance * Eigen::Matrix2d::Identity();
      EXPECT_TRUE(sum.isApprox(track.covariance[i], 1e-12));
      EXPECT_GE(errors.own.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-12);
      EXPECT_TRUE(covariance_of_sum(track, {{i, 1}}).isApprox(track.covariance[i], 1e-12));
    }
  }
}

// Two points of a slow error: 2 s^2 (1 - exp(-dt/T)) between them.
TEST(TrackErrors, OfADifferenceAreWhatBothPointsDoNotShare) {
  TrackTable track;
  track.time = {0, 0.1, 0.4};
  track.slow = {{2e-6, 0.2}};
  track.position.resize(3, Eigen::Vector2d::Zero());
  const Eigen::Matrix2d white = 1e-12 * Eigen::Matrix2d::Identity();
  track.covariance.resize(3, white + 4e-12 * Eigen::Matrix2d::Identity());
  const Eigen::Matrix2d found = covariance_of_sum(track, {{0, -1}, {2, 1}});
  const double expected = 2e-12 + 2 * 4e-12 * (1 - std::exp(-2));
  EXPECT_TRUE(found.isApprox(expected * Eigen::Matrix2d::Identity(), 1e-12)) << found;
}

}  // namespace
}  // namespace tribotrack::fit::internal
