#include "vision/layers/model/part.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "vision/layers/part_by_hand.h"

namespace tribotrack::vision {
namespace {

using test::PartByHand;
using test::pointers_to;
using test::state_of;

constexpr int kBeyond = 6;  ///< px of a window about the part's grid

std::vector<KeptWindow> windows_of(const PartByHand& part, int count, double noise, bool flicker = false) {
  std::mt19937 random(3);
  std::vector<KeptWindow> out;
  for (int k = 0; k < count; ++k) {
    LayeredState s = state_of(k);
    if (flicker) {
      s.gain = 1 + 0.05 * std::sin(0.7 * k);
      s.ground_gain = 1 + 0.05 * std::cos(1.3 * k);
      s.slope_x = 1e-3 * std::sin(0.4 * k);
      s.slope_y = 1e-3 * std::cos(0.6 * k);
    }
    out.push_back(part.window(s, part.half + kBeyond, noise, random));
  }
  return out;
}

/// What a first round starts from.
PartPictures nothing_known(const PartByHand& part) {
  const int size = 2 * part.half + 1;
  return {part.half, Picture(size, size), blurred_rim(part.half, part.radius, part.blur),
          Picture(size, size, 1e20F)};
}

PartPictures learnt(const std::vector<KeptWindow>& windows, const GroundPicture& ground, PartPictures part,
                    const Picture& prior, double noise_variance, int rounds, bool trim = false,
                    bool opaque = true) {
  for (int round = 0; round < rounds; ++round) {
    PartRegression regression(part, ground);
    regression.add(pointers_to(windows), trim);
    part = regression.solve(noise_variance, prior, opaque);
  }
  return part;
}

/// act(u, v, place in the pictures) for all places nearer than `reach` to the centre.
template <class Act>
void about_centre(const PartByHand& part, double from, double to, const Act& act) {
  for (int v = -part.half; v <= part.half; ++v)
    for (int u = -part.half; u <= part.half; ++u)
      if (const double rho = std::hypot(u, v); rho >= from && rho < to)
        act(u, v, static_cast<std::size_t>((v + part.half) * (2 * part.half + 1) + u + part.half));
}

double mean_over(const PartByHand& part, const Picture& picture, double from, double to) {
  double sum = 0, n = 0;
  about_centre(part, from, to, [&](int, int, std::size_t at) {
    sum += static_cast<double>(picture.levels()[at]);
    ++n;
  });
  return sum / n;
}

TEST(PartRegression, IsTheSameBitForBitForAnyNumberOfThreads) {
  const PartByHand part;
  const GroundPicture ground = part.ground(1);
  const std::vector<KeptWindow> windows = windows_of(part, 24, 1, true);
  const PartPictures before = part.pictures(1);
  const auto learnt_by = [&](int threads) {
    PartRegression regression(before, ground);
    regression.add(pointers_to(windows), true, nullptr, threads);
    return regression.solve(1, before.share);
  };
  const PartPictures one = learnt_by(1);
  for (const int threads : {2, 5}) {
    const PartPictures found = learnt_by(threads);
    EXPECT_TRUE(std::ranges::equal(found.level.levels(), one.level.levels()));
    EXPECT_TRUE(std::ranges::equal(found.share.levels(), one.share.levels()));
    EXPECT_TRUE(std::ranges::equal(found.variance.levels(), one.variance.levels()));
    EXPECT_EQ(found.blend, one.blend);
  }
}

TEST(PartRegression, FindsBothPicturesWhateverTheLight) {
  PartByHand part;
  part.shadow = 0.15;
  const GroundPicture ground = part.ground(1e-4);
  const Picture prior = blurred_rim(part.half, part.radius, part.blur);
  const std::vector<KeptWindow> windows = windows_of(part, 96, 0, true);
  const PartPictures exact = part.pictures(1);
  for (const bool opaque : {true, false}) {
    const PartPictures found = learnt(windows, ground, nothing_known(part), prior, 0.01, 6, false, opaque);
    for (std::size_t i = 0; i < exact.level.levels().size(); ++i) {
      ASSERT_NEAR(found.level.levels()[i], exact.level.levels()[i], 0.05) << i;
      ASSERT_NEAR(found.share.levels()[i], exact.share.levels()[i], 0.01) << i;
    }
  }
  EXPECT_LT(exact.share.at(2 * part.half - 10, part.half), 0.87);  // the shadow is not in the prior
}

TEST(PartRegression, WhatIsLeftIsTheNoise) {
  constexpr double kNoise = 2;
  const PartByHand part;
  const GroundPicture ground = part.ground(1e-4);
  // Gains of part and ground that go their own ways are no noise.
  const PartPictures found =
      learnt(windows_of(part, 160, kNoise, true), ground, part.pictures(kNoise * kNoise),
             part.pictures(1).share, kNoise * kNoise, 1);
  // The larger of a place's own variance, known to 11 %, and that of its surroundings.
  for (const auto& [from, to] : {std::pair{0.0, part.radius - 4},
                                 {part.radius - 3, part.radius + 3},
                                 {part.radius + 4, part.half - 1.0}}) {
    const double v = mean_over(part, found.variance, from, to) / (kNoise * kNoise);
    EXPECT_GT(v, 1.0) << from;
    EXPECT_LT(v, 1.08) << from;
  }
  about_centre(part, 0, part.radius - 4 * part.blur, [&](int u, int v, std::size_t at) {
    ASSERT_NEAR(found.share.levels()[at], 0, 1e-3) << u << " " << v;
  });
}

// At the rim both unknowns of a place are free: of 12 windows 10 tell the noise. Theirs is a chi^2_10 / 10 =
// g, and the larger of g and that of the surroundings, 1, is 1 + a^(a - 1) exp(-a) / Gamma(a) on average, a
// = 5.
TEST(PartRegression, WhatFewWindowsLeaveIsTheNoiseForTwoUnknownsLess) {
  constexpr double kNoise = 2, kHalf = 5;
  const PartByHand part;
  const GroundPicture ground = part.ground(1e-4);
  const PartPictures found =
      learnt(windows_of(part, 12, kNoise, true), ground, part.pictures(kNoise * kNoise),
             part.pictures(1).share, kNoise * kNoise, 1);
  const double v = mean_over(part, found.variance, part.radius - 3, part.radius + 3) / (kNoise * kNoise);
  EXPECT_NEAR(v, 1 + std::pow(kHalf, kHalf - 1) * std::exp(-kHalf) / std::tgamma(kHalf), 0.06);
}

// A sheen of the ground's own pattern on the part, as a twentieth of the ground below showed through it: a
// picture may take it up only where it is not held to be opaque.
TEST(PartRegression, AlphaTakesUpASheenUnlessThePartIsOpaque) {
  constexpr double kNoise = 0.5, kSheen = 0.05;
  PartByHand part;
  part.sheen = kSheen;
  const GroundPicture ground = part.ground(1e-4);
  const Picture prior = blurred_rim(part.half, part.radius, part.blur);
  const std::vector<KeptWindow> windows = windows_of(part, 96, kNoise);
  const auto inside = [&](bool opaque) {
    const PartPictures found =
        learnt(windows, ground, nothing_known(part), prior, kNoise * kNoise, 4, false, opaque);
    return mean_over(part, found.share, 2, part.radius - 4 * part.blur);
  };
  EXPECT_NEAR(inside(true), 0, 5e-3);
  EXPECT_NEAR(inside(false), kSheen, 2e-3);
}

// Ground that is not known in some of the frames is no noise of the part's, and does not disturb its
// pictures.
TEST(PartRegression, GroundThatIsHardlyKnownWeighsLittle) {
  constexpr double kNoise = 1;
  const PartByHand part;
  Picture shown(PartByHand::region.width, PartByHand::region.height);
  for (int y = 0; y < shown.height(); ++y)
    for (int x = 0; x < shown.width(); ++x) shown.at(x, y) = static_cast<float>(part.ground_level(x, y));
  GroundPicture ground(PartByHand::region);
  for (int k = 0; k < 50; ++k) ground.add(shown, 0, 0, {}, {90, 65, 12});
  ground.finish(kNoise * kNoise);
  const PartPictures found = learnt(windows_of(part, 160, kNoise), ground, part.pictures(kNoise * kNoise),
                                    part.pictures(1).share, kNoise * kNoise, 4);
  const PartPictures exact = part.pictures(1);
  double rms = 0, n = 0;
  about_centre(part, 0, part.half - 1.0, [&](int, int, std::size_t at) {
    rms += std::pow(static_cast<double>(found.level.levels()[at] - exact.level.levels()[at]), 2);
    ++n;
  });
  EXPECT_LT(std::sqrt(rms / n), 0.3);
  const double v = mean_over(part, found.variance, part.radius - 3, part.half - 1.0) / (kNoise * kNoise);
  EXPECT_GT(v, 0.95);
  EXPECT_LT(v, 1.25);
}

TEST(PartRegression, WhatCoversThePartIsTrimmed) {
  constexpr double kNoise = 1;
  const PartByHand part;
  const GroundPicture ground = part.ground(1e-4);
  std::vector<KeptWindow> windows = windows_of(part, 96, kNoise);
  for (std::size_t k = 0; k < windows.size(); k += 10) {
    KeptWindow& w = windows[k];
    for (int y = 30; y < 46; ++y)
      for (int x = 30; x < 46; ++x) w.picture.at(x, y) += 60;
    w.spline = QuinticSpline(w.picture);
  }
  const PartPictures exact = part.pictures(kNoise * kNoise);
  const auto off = [&](bool trim) {
    const PartPictures found = learnt(windows, ground, exact, exact.share, kNoise * kNoise, 1, trim);
    double sum = 0;
    about_centre(part, 0, 4, [&](int, int, std::size_t at) {
      sum += static_cast<double>(found.level.levels()[at] - exact.level.levels()[at]);
    });
    return sum / 49;
  };
  EXPECT_GT(off(false), 5);             // a tenth of 60
  EXPECT_LT(std::abs(off(true)), 0.1);  // the noise of 86 windows
}

// What blurs part and ground together is found where there is any, and is not where there is none.
TEST(PartRegression, BlendIsFound) {
  for (const double kappa : {0.0, 1.5}) {
    PartByHand part;
    part.kappa = kappa;
    const GroundPicture ground = part.ground(1e-4);
    PartPictures start = part.pictures(0.04);
    start.blend = kPixelBlend;
    const PartPictures found = learnt(windows_of(part, 96, 0.2), ground, start, start.share, 0.04, 6);
    EXPECT_NEAR(found.blend, kappa, 0.03) << kappa;
  }
}

TEST(PartRegression, PlacesThatAreNeverSeenHaveTheWidestVariance) {
  const PartByHand part;
  const GroundPicture ground = part.ground(1e-4);
  std::vector<KeptWindow> windows = windows_of(part, 32, 1);
  // Windows cut off 10 px to the left of the part's centre.
  for (KeptWindow& w : windows) {
    Picture cut(w.picture.width() - 28, w.picture.height());
    for (int y = 0; y < cut.height(); ++y)
      for (int x = 0; x < cut.width(); ++x) cut.at(x, y) = w.picture.at(x + 28, y);
    w.picture = std::move(cut);
    w.x += 28;
    w.spline = QuinticSpline(w.picture);
  }
  const PartPictures before = part.pictures(1);
  const PartPictures found = learnt(windows, ground, before, before.share, 1, 1);
  float widest = 0;
  for (const float v : found.variance.levels()) widest = std::max(widest, v);
  EXPECT_EQ(found.variance.at(10, part.half), widest);
  EXPECT_EQ(found.level.at(10, part.half), before.level.at(10, part.half));
  EXPECT_LT(found.variance.at(part.half + 4, part.half), 0.9F * widest);
}

}  // namespace
}  // namespace tribotrack::vision
