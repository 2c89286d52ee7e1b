#include "vision/layers/registration/registration.h"
#include "vision/layers/layers.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "vision/analytic_scene.h"
#include "vision/layers/model/model.h"

namespace tribotrack::vision {
namespace {

/// The model of vision/layers/model/state.h written out: a disc with a blurred rim and marks over a ground of
/// waves, all known at every place, so that windows of it owe nothing to interpolation.
struct PartByHand {
  double radius = 20, blur = 1.5;
  int half = 32;
  double kappa = 0;                              ///< px^2
  static constexpr Rect region{0, 0, 180, 130};  ///< of the platform

  test::Waves waves;  ///< of the ground about its level
  double mean = 0;    ///< mean G over the region

  PartByHand() {
    std::mt19937 random(11);
    waves = test::random_waves(random, 12, 8, 8);
    for (int y = 0; y < region.height; ++y)
      for (int x = 0; x < region.width; ++x)
        mean += ground_level(region.x + x, region.y + y) / (region.width * region.height);
  }

  double ground_level(double x, double y) const { return 70 + waves(x, y); }
  double share(double u, double v) const {
    return 0.5 * std::erfc((radius - std::hypot(u, v)) / (blur * std::numbers::sqrt2));
  }
  double face(double u, double v) const {
    return 120 + 25 * std::exp(-0.5 * (std::pow(u - 7, 2) + std::pow(v + 5, 2)) / 6);
  }
  /// F.
  double level(double u, double v) const { return (1 - share(u, v)) * face(u, v) + share(u, v) * mean; }

  /// I at a pixel of the camera.
  double seen(const LayeredState& s, double x, double y) const {
    constexpr double kStep = 1e-4;
    const double u = x - s.centre.x, v = y - s.centre.y, gx = x - s.ground.x, gy = y - s.ground.y;
    double below = share(u, v) * ground_level(gx, gy);
    if (kappa > 0)
      below += kappa / (4 * kStep * kStep) *
               ((share(u + kStep, v) - share(u - kStep, v)) *
                    (ground_level(gx + kStep, gy) - ground_level(gx - kStep, gy)) +
                (share(u, v + kStep) - share(u, v - kStep)) *
                    (ground_level(gx, gy + kStep) - ground_level(gx, gy - kStep)));
    return s.gain * (1 + s.slope_x * u + s.slope_y * v) * (level(u, v) - share(u, v) * mean) +
           s.ground_gain * below;
  }

  /// Its window of `reach` px about the part, with white noise.
  KeptWindow window(const LayeredState& s, int reach, double noise, std::mt19937& random) const {
    std::normal_distribution<double> gauss(0, 1);
    KeptWindow w;
    w.state = s;
    w.x = static_cast<int>(std::lround(s.centre.x)) - reach;
    w.y = static_cast<int>(std::lround(s.centre.y)) - reach;
    w.picture = Picture(2 * reach + 1, 2 * reach + 1);
    for (int j = 0; j <= 2 * reach; ++j)
      for (int i = 0; i <= 2 * reach; ++i)
        w.picture.at(i, j) = static_cast<float>(seen(s, w.x + i, w.y + j) + noise * gauss(random));
    w.spline = QuinticSpline(w.picture);
    return w;
  }

  /// The ground's picture, known from four frames of this noise.
  GroundPicture ground(double noise_variance) const {
    Picture picture(region.width, region.height);
    for (int y = 0; y < region.height; ++y)
      for (int x = 0; x < region.width; ++x)
        picture.at(x, y) = static_cast<float>(ground_level(region.x + x, region.y + y));
    GroundPicture out(region);
    for (int k = 0; k < 4; ++k) out.add(picture, region.x, region.y, {}, {-1000, -1000, 1});
    out.finish(noise_variance);
    return out;
  }

  /// Its two pictures, and the variance of white noise.
  PartPictures pictures(double variance) const {
    const int size = 2 * half + 1;
    const auto v = static_cast<float>(variance);
    PartPictures out{half, Picture(size, size), Picture(size, size), Picture(size, size, v), kappa};
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        out.level.at(i, j) = static_cast<float>(level(i - half, j - half));
        out.share.at(i, j) = static_cast<float>(share(i - half, j - half));
      }
    return out;
  }
};

/// A state by the number of a frame: the part winds over the region, the platform circles.
LayeredState state_of(int k) {
  LayeredState s;
  s.centre = {90 + 31.4 * std::sin(0.37 * k), 65 + 14.3 * std::cos(0.23 * k)};
  s.ground = {4.3 * std::cos(0.9 * k), 4.1 * std::sin(1.1 * k)};
  return s;
}

constexpr double kFrames = 100;  ///< that the pictures are said to be learnt from

/// A registration that knows the pictures, and the ground, without noise.
struct Known {
  PartByHand part;
  double noise;
  GroundPicture ground;
  LayeredRegistration registration;

  explicit Known(double with_noise, const PartByHand& of = PartByHand())
      : part(of), noise(with_noise), ground(part.ground(1e-4 * noise * noise)), registration(ground) {
    registration.set_part(part.pictures(noise * noise), kFrames);
  }
  KeptWindow window(const LayeredState& s, std::mt19937& random) const {
    return part.window(s, part.half + 4, noise, random);
  }
  std::optional<LayeredFix> measured(const KeptWindow& w, Point off = {}) {
    LayeredState start;
    start.centre = {w.state.centre.x + off.x, w.state.centre.y + off.y};
    start.ground = w.state.ground;
    return registration.refine(w.picture, w.x, w.y, start, {});
  }
};

/// Levels at the places of a window for which `there`, from the part's centre, is true.
template <class There>
void cover(KeptWindow& w, float level, const There& there) {
  for (int y = 0; y < w.picture.height(); ++y)
    for (int x = 0; x < w.picture.width(); ++x)
      if (there(w.x + x - w.state.centre.x, w.y + y - w.state.centre.y)) w.picture.at(x, y) = level;
}

TEST(LayeredRegistration, PlaceIsFoundExactlyWithoutNoise) {
  PartByHand part;
  part.kappa = 0.5;
  Known known(0.03, part);
  std::mt19937 random(1);
  for (int k = 0; k < 40; ++k) {
    LayeredState s = state_of(k);
    s.gain = 1 + 0.1 * std::sin(k);
    s.ground_gain = 1 + 0.05 * std::cos(k);
    const KeptWindow w = part.window(s, part.half + 4, 0, random);
    const auto fix = known.measured(w, {0.6 * std::sin(2.0 * k), 0.6 * std::cos(3.0 * k)});
    ASSERT_TRUE(fix.has_value()) << k;
    EXPECT_NEAR(fix->state.centre.x, s.centre.x, 1e-3) << k;
    EXPECT_NEAR(fix->state.centre.y, s.centre.y, 1e-3) << k;
    EXPECT_NEAR(fix->state.gain, s.gain, 1e-4) << k;
    EXPECT_NEAR(fix->state.ground_gain, s.ground_gain, 1e-4) << k;
    EXPECT_GT(fix->ncc, 0.9999) << k;
  }
}

// Over noisy frames: errors as large as the covariance says, chi^2 of 1, pulls of the clusters that add up to
// nothing and whose squares are the errors', halves that disagree as much as the covariance says.
TEST(LayeredRegistration, WhatItSaysOfItsErrorIsTrueOfWhiteNoise) {
  Known known(1.5);
  std::mt19937 random(2);
  constexpr int kTrials = 400;
  double errors = 0, chi_squared = 0, slope_x = 0, left_right = 0, top_bottom = 0, checkerboard = 0;
  Eigen::Matrix2d told = Eigen::Matrix2d::Zero();
  std::vector<ClusterPulls> pulls;
  for (int k = 0; k < kTrials; ++k) {
    const KeptWindow w = known.window(state_of(k), random);
    const auto fix = known.measured(w, {0.1, -0.1});
    ASSERT_TRUE(fix.has_value()) << k;
    const Eigen::Vector2d error(fix->state.centre.x - w.state.centre.x,
                                fix->state.centre.y - w.state.centre.y);
    const Eigen::Matrix2d inverse = fix->covariance.inverse();
    const auto square = [&](const Eigen::Vector2d& e) { return e.dot(inverse * e) / (2 * kTrials); };
    errors += square(error);
    told += fix->covariance / kTrials;
    chi_squared += fix->chi_squared / kTrials;
    slope_x += fix->state.slope_x;
    pulls.push_back(known.registration.cluster_pulls());
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    for (const Eigen::Vector2f& pull : pulls.back()) sum += pull;
    // The last step, of less than a tenth of a standard deviation, which is taken without another look.
    EXPECT_LT(sum.norm(), 0.11 * std::sqrt(0.5 * fix->covariance.trace()));
    const auto halves = known.registration.halves();
    ASSERT_TRUE(halves.has_value());
    left_right += square(halves->left_right);
    top_bottom += square(halves->top_bottom);
    checkerboard += square(halves->checkerboard);
  }
  // 800 squares scatter by 5 %.
  EXPECT_NEAR(errors, 1, 0.15);
  EXPECT_NEAR(chi_squared, 1, 0.02);
  EXPECT_NEAR(left_right, 1, 0.15);
  EXPECT_NEAR(top_bottom, 1, 0.15);
  EXPECT_NEAR(checkerboard, 1, 0.15);
  EXPECT_NEAR(slope_x, 0, 1e-5);
  const RunScatter scatter = run_scatter(pulls, known.registration.share_taken());
  EXPECT_NEAR(scatter.covariance.trace(), told.trace(), 0.1 * told.trace());
  EXPECT_LT(scatter.slow, 0.1 * scatter.white);
}

TEST(LayeredRegistration, FrameThatEndsWithinThePartTellsAsMuchAsItShows) {
  Known known(0.5);
  std::mt19937 random(4);
  for (int k = 0; k < 5; ++k) {
    const KeptWindow w = known.window(state_of(k), random);
    const auto cut = [&](int beside) {
      KeptWindow out = w;
      const int first = static_cast<int>(std::lround(w.state.centre.x)) + beside;
      out.picture = Picture(w.x + w.picture.width() - first, w.picture.height());
      for (int y = 0; y < out.picture.height(); ++y)
        for (int x = 0; x < out.picture.width(); ++x) out.picture.at(x, y) = w.picture.at(first - w.x + x, y);
      out.x = first;
      return out;
    };
    const auto whole = known.measured(w), some = known.measured(cut(-14)), half = known.measured(cut(0));
    ASSERT_TRUE(whole.has_value());
    ASSERT_TRUE(some.has_value());
    EXPECT_FALSE(half.has_value());
    EXPECT_GT(some->covariance(0, 0), whole->covariance(0, 0));
    EXPECT_NEAR(some->state.centre.x, w.state.centre.x, 4 * std::sqrt(some->covariance(0, 0)));
    EXPECT_NEAR(some->state.centre.y, w.state.centre.y, 4 * std::sqrt(some->covariance(1, 1)));
  }
}

TEST(LayeredRegistration, WhatCoversALittleOfThePartIsLeftOut) {
  Known known(0.5);
  std::mt19937 random(5);
  for (int k = 0; k < 10; ++k) {
    KeptWindow w = known.window(state_of(k), random);
    const auto before = known.measured(w);
    cover(w, 130, [](double u, double v) { return u > 13 && std::abs(v) < 5; });
    const auto fix = known.measured(w);
    ASSERT_TRUE(before.has_value());
    ASSERT_TRUE(fix.has_value()) << k;
    EXPECT_GT(fix->covariance(0, 0), before->covariance(0, 0));
    EXPECT_NEAR(fix->state.centre.x, w.state.centre.x, 4 * std::sqrt(fix->covariance(0, 0))) << k;
    EXPECT_NEAR(fix->state.centre.y, w.state.centre.y, 4 * std::sqrt(fix->covariance(1, 1))) << k;
  }
}

TEST(LayeredRegistration, CoveredPartIsNotMeasured) {
  Known known(0.5);
  std::mt19937 random(6);
  for (int k = 0; k < 10; ++k) {
    KeptWindow w = known.window(state_of(k), random);
    cover(w, 200, [](double u, double v) { return u + v > -8; });
    EXPECT_FALSE(known.measured(w).has_value()) << k;
  }
}

}  // namespace
}  // namespace tribotrack::vision
