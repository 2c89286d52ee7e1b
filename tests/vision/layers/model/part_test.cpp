#include "vision/layers/model/part.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "vision/layers/part_by_hand.h"

namespace tribotrack::vision {
namespace {

using test::PartByHand;

/// Under light of its own in every frame: of the part, its slope, and of the ground.
std::vector<KeptWindow> windows_of(const PartByHand& part, int count, double noise) {
  std::mt19937 random(3);
  std::vector<KeptWindow> out;
  for (int k = 0; k < count; ++k) {
    LayeredState s = test::state_of(k);
    s.gain = 1 + 0.05 * std::sin(0.7 * k);
    s.ground_gain = 1 + 0.05 * std::cos(1.3 * k);
    s.slope_x = 1e-3 * std::sin(0.4 * k);
    s.slope_y = 1e-3 * std::cos(0.6 * k);
    out.push_back(part.window(s, part.half + 6, noise, random));
  }
  return out;
}

PartPictures learnt(const std::vector<KeptWindow>& windows, const GroundPicture& ground, PartPictures part,
                    const Picture& prior, double noise_variance, int rounds) {
  for (int round = 0; round < rounds; ++round)
    part = learn_pictures(part, ground, test::pointers_to(windows), false, noise_variance, prior);
  return part;
}

TEST(PartRegression, FindsBothPicturesWhateverTheLight) {
  PartByHand part;
  part.shadow = 0.15;
  const int size = 2 * part.half + 1;
  const Picture prior = blurred_rim(part.half, part.radius, part.blur);
  const PartPictures nothing_known{part.half, Picture(size, size), prior, Picture(size, size, 1e20F)};
  const GroundPicture ground = part.ground(1e-4);
  const std::vector<KeptWindow> windows = windows_of(part, 96, 0);
  const PartPictures exact = part.pictures(1);
  const PartPictures found = learnt(windows, ground, nothing_known, prior, 0.01, 6);
  for (std::size_t i = 0; i < exact.level.levels().size(); ++i) {
    ASSERT_NEAR(found.level.levels()[i], exact.level.levels()[i], 0.05) << i;
    ASSERT_NEAR(found.share.levels()[i], exact.share.levels()[i], 0.01) << i;
  }
  EXPECT_LT(exact.share.at(2 * part.half - 10, part.half), 0.87);  // the shadow is not in the prior
}

TEST(PartRegression, WhatIsLeftIsTheNoise) {
  constexpr double kVariance = 4;
  const PartByHand part;
  const PartPictures found = learnt(windows_of(part, 160, 2), part.ground(1e-4), part.pictures(kVariance),
                                    part.pictures(1).share, kVariance, 1);
  // The larger of a place's own variance, known to 11 %, and that of its surroundings: inside, at the rim,
  // beside.
  for (const auto& [from, to] : {std::pair{0.0, part.radius - 4},
                                 {part.radius - 3, part.radius + 3},
                                 {part.radius + 4, part.half - 1.0}}) {
    double sum = 0, n = 0;
    for (int v = -part.half; v <= part.half; ++v)
      for (int u = -part.half; u <= part.half; ++u)
        if (const double rho = std::hypot(u, v); rho >= from && rho < to) {
          sum += static_cast<double>(found.variance.at(u + part.half, v + part.half)) / kVariance;
          ++n;
        }
    EXPECT_GT(sum / n, 1.0) << from;
    EXPECT_LT(sum / n, 1.08) << from;
  }
}

}  // namespace
}  // namespace tribotrack::vision
