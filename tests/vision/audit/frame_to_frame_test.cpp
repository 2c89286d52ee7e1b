#include "vision/audit/frame_to_frame.h"

#include <gtest/gtest.h>

#include <array>

#include "vision/audit/synthetic_track.h"

namespace tribotrack::vision {
namespace {

using test::kSigma;
using test::track_of;
using test::white;

auto noise(double factor = 1) {
  return [factor](int, std::mt19937& random) { return white(random, factor * kSigma); };
}

double at_rest(int) {
  return 0;
}

TEST(HighFrequency, WhiteNoiseIsFoundByTheLowestOrderAndItsScatterIsTrue) {
  double mean = 0, spread = 0, claimed = 0;
  int low = 0, silent = 0;
  constexpr int kTrials = 200;
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    const auto found = high_frequency(stretches(track_of(200, seed, at_rest, noise())), kAlongX);
    silent += !found;
    if (!found) continue;
    mean += found->noise.value / kTrials;
    spread += std::pow(found->noise.value - 1, 2) / kTrials;
    claimed += found->noise.scatter / kTrials;
    low += found->order == 2;
  }
  EXPECT_NEAR(mean, 1, 0.02);
  EXPECT_NEAR(claimed / std::sqrt(spread), 1, 0.2);
  // Three standard deviations of skewed estimates: one in a hundred is taken for a motion.
  EXPECT_LE(silent, 2);
  EXPECT_GE(low, 190);
}

TEST(HighFrequency, ReportedTooSmallIsSeen) {
  const auto found = high_frequency(stretches(track_of(600, 1, at_rest, noise(1.8))), kAlongX);
  EXPECT_NEAR(std::sqrt(found->noise.value), 1.8, 0.1);
}

/// On a platform at 10 Hz filmed at 1000 frames/s second differences see the motion, fourth do not.
TEST(HighFrequency, AMotionThatLowOrdersSeeTakesAHigherOne) {
  const auto circle = [](int k) { return 15 * std::cos(0.0628 * k); };
  const auto found = high_frequency(stretches(track_of(600, 1, circle, noise())), kAlongX);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->order, 4);
  EXPECT_NEAR(found->noise.value, 1, 0.15);
}

TEST(HighFrequency, AMotionThatIsFastAgainstTheFrameRateSaysNothing) {
  const auto circle = [](int k) { return 15 * std::cos(0.9 * k); };
  EXPECT_FALSE(high_frequency(stretches(track_of(600, 1, circle, noise())), kAlongX));
}

TEST(HighFrequency, SingleOutliersAndGapsDoNotMatter) {
  Track track = track_of(
      600, 1, [](int k) { return 0.3 * k; }, noise());
  track.points[100].x += 3;
  track.points[400].y -= 3;
  for (std::size_t k = 200; k < 210; ++k) track.points[k].status = TrackStatus::lost;
  for (std::size_t k = 210; k < 600; ++k) track.points[k].x += 50;
  for (const Axis& axis : {kAlongX, kAlongY})
    EXPECT_NEAR(high_frequency(stretches(track), axis)->noise.value, 1, 0.2);
}

TEST(HighFrequency, ErrorsThatAlternateAreAsLargeAsTheyAre) {
  const auto alternating = [](int k, std::mt19937& random) {
    return (k % 2 == 0 ? 3 : -3) * kSigma + white(random);
  };
  const auto found = high_frequency(stretches(track_of(6000, 1, at_rest, alternating)), kAlongX);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->noise.value, (9 * 16 + 6) / 6.0, 1);  // second differences of +-1 are 4
  EXPECT_NEAR(without_alternation(*found, -0.9).value, 10, 0.5);
  EXPECT_EQ(without_alternation(*found, 0.7).value, found->noise.value);
}

TEST(HighFrequency, FewFramesTellNothing) {
  EXPECT_FALSE(high_frequency(stretches(track_of(27, 1, at_rest, noise())), kAlongX));
}

TEST(LocalPolynomial, LeavesNothingOfAPolynomialOfItsDegree) {
  for (const int order : {2, 4, 6}) {
    const LocalPolynomial fit(order);
    std::vector<double> values;
    for (int k = 0; k < 40; ++k) values.push_back(3 - 0.2 * k + std::pow(0.05 * k, order));
    const auto left = fit.residual(values);
    ASSERT_EQ(left.size(), 40 - 2 * fit.half());
    for (const double r : left) EXPECT_NEAR(r, 0, 1e-9);
    EXPECT_NEAR(fit.smoothed(values)[20], values[20], 1e-9);
  }
}

/// Savitzky and Golay's table for a quadratic over nine points: (-21 14 39 54 59 54 39 14 -21) / 231.
TEST(LocalPolynomial, WeightsAreTheirTable) {
  const LocalPolynomial fit(2);
  ASSERT_EQ(fit.half(), 4U);
  std::vector<double> one(9, 0);
  const double table[] = {-21, 14, 39, 54, 59, 54, 39, 14, -21};
  for (std::size_t k = 0; k < 9; ++k) {
    one.assign(9, 0);
    one[k] = 231;
    EXPECT_NEAR(fit.residual(one)[0], (k == 4 ? 231 : 0) - table[k], 1e-9);
  }
  EXPECT_NEAR(fit.smoothed_variance(), 59.0 / 231, 1e-12);
}

TEST(LocalPolynomial, TransposedIsTheAdjoint) {
  const LocalPolynomial fit(4);
  std::mt19937 random(1);
  std::vector<double> a(50), b(50 - 2 * fit.half());
  for (double& v : a) v = white(random, 1);
  for (double& v : b) v = white(random, 1);
  const auto left = fit.residual(a), back = fit.transposed(b, 50);
  double forth = 0, and_back = 0;
  for (std::size_t k = 0; k < b.size(); ++k) forth += left[k] * b[k];
  for (std::size_t k = 0; k < 50; ++k) and_back += a[k] * back[k];
  EXPECT_NEAR(forth, and_back, 1e-10);
}

/// Each error is rho times the last of its coordinate and white noise.
std::function<double(int, std::mt19937&)> autoregression(double rho) {
  return [rho, last = std::array<double, 2>{}](int, std::mt19937& random) mutable {
    last = {last[1], rho * last[0] + white(random)};
    return last[1];
  };
}

/// So that the bisection is right: on both sides of white noise a higher correlation leaves a higher one.
TEST(LocalPolynomial, ResidualsOfAnAutoregressionAreAlikeAsItIs) {
  for (const int order : {2, 4, 6}) {
    const LocalPolynomial fit(order);
    double last = -1;
    for (double rho = -0.99; rho < 0.99; rho += 0.01) {
      EXPECT_GT(fit.lag1(rho), last) << order << " " << rho;
      last = fit.lag1(rho);
    }
  }
}

TEST(Lag1, WhiteNoiseHasNoneAndAlternatingErrorsTheirOwn) {
  const auto rest = [](int) { return 0.0; };
  const auto lag1 = [&](const std::function<double(int, std::mt19937&)>& error) {
    return lag1_correlation(stretches(track_of(4000, 1, rest, error)), kAlongX, LocalPolynomial(2))->value;
  };
  EXPECT_NEAR(lag1([](int, std::mt19937& r) { return white(r); }), 0, 0.05);
  EXPECT_NEAR(lag1([](int k, std::mt19937& r) { return (k % 2 == 0 ? 0.1 : -0.1) + white(r); }), -0.98, 0.02);
  for (const double rho : {-0.8, -0.4, 0.5}) EXPECT_NEAR(lag1(autoregression(rho)), rho, 0.06);
  EXPECT_FALSE(
      lag1_correlation(stretches(track_of(50, 1, rest, [](int, std::mt19937& r) { return white(r); })),
                       kAlongX, LocalPolynomial(2)));
}

}  // namespace
}  // namespace tribotrack::vision
