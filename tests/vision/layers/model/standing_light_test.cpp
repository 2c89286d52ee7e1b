#include "vision/layers/model/light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "vision/layers/part_by_hand.h"

namespace tribotrack::vision {
namespace {

using test::PartByHand;
using test::state_of;

constexpr double kNoise = 1, kInside = 14;

/// A lamp's glare in the middle of the path.
double glare(double x, double y) {
  return 12 * std::exp(-0.5 * (std::pow(x - 95, 2) + std::pow(y - 62, 2)) / (12 * 12));
}

std::vector<KeptWindow> windows_of(const PartByHand& part) {
  std::mt19937 random(1);
  std::vector<KeptWindow> out;
  for (int k = 0; k < 120; ++k) {
    LayeredState s = state_of(k);
    s.gain = s.ground_gain = 1 + 0.03 * std::sin(k);
    out.push_back(part.window(s, part.half + 4, kNoise, random));
  }
  return out;
}

/// L as it is taken out of a part over which nothing of the ground shows.
Picture level_of(const StandingLight& light) {
  constexpr int kReach = 8;  // px: well inside the rim
  Picture level(PartByHand::region.width, PartByHand::region.height);
  for (int y = kReach; y < level.height() - kReach; y += 2 * kReach)
    for (int x = kReach; x < level.width() - kReach; x += 2 * kReach) {
      Picture taken(2 * kReach, 2 * kReach);
      light.take_out(taken, x - kReach, y - kReach, {static_cast<double>(x), static_cast<double>(y)});
      for (int j = 0; j < 2 * kReach; ++j)
        for (int i = 0; i < 2 * kReach; ++i) level.at(x - kReach + i, y - kReach + j) = -taken.at(i, j);
    }
  return level;
}

// 10 000 pixels, each against its own frames: chance is a few per cent.
TEST(StandingLight, NoneHasAnEvidenceOfOne) {
  const PartByHand part;
  StandingLight light(PartByHand::region, part.pictures(1).share);
  EXPECT_EQ(light.evidence(), 1);
  light.look(windows_of(part), part.pictures(1), kInside);
  EXPECT_NEAR(light.evidence(), 1, 0.1);
}

TEST(StandingLight, IsFoundOverThePath) {
  PartByHand part;
  part.standing = glare;
  std::vector<KeptWindow> windows = windows_of(part);
  const PartPictures pictures = part.pictures(1);
  StandingLight light(PartByHand::region, pictures.share);
  light.look(windows, pictures, kInside);
  EXPECT_GT(light.evidence(), 20);
  for (int round = 0; round < 4; ++round) light.learn(windows, pictures, kInside);
  light.look(windows, pictures, kInside);
  EXPECT_NEAR(light.evidence(), 1, 0.15);
  const Picture found = level_of(light);
  // Where the face has been, the path's margins excepted.
  double square = 0, n = 0;
  for (int y = 50; y < 80; ++y)
    for (int x = 60; x < 120; ++x) {
      square += std::pow(found.at(x, y) - glare(x, y), 2);
      ++n;
      ASSERT_NEAR(found.at(x, y), glare(x, y), 0.08 * 12) << x << " " << y;
    }
  EXPECT_LT(std::sqrt(square / n), 0.03 * 12);
}

// It is continued by planes for a few pixels, and is none where nothing was seen.
TEST(StandingLight, IsNoneFarFromThePath) {
  PartByHand part;
  part.standing = [](double, double) { return 10; };
  std::vector<KeptWindow> windows;
  std::mt19937 random(1);
  LayeredState s;
  s.centre = {60.2, 60.4};
  for (int k = 0; k < 32; ++k) windows.push_back(part.window(s, part.half + 4, 0, random));
  const PartPictures pictures = part.pictures(1);
  StandingLight light(PartByHand::region, pictures.share);
  for (int round = 0; round < 3; ++round) light.learn(windows, pictures, kInside);
  const Picture found = level_of(light);
  EXPECT_NEAR(found.at(60, 60), 10, 0.1);
  EXPECT_NEAR(found.at(60 + 16, 60), 10, 0.5);
  EXPECT_EQ(found.at(60 + 40, 60), 0);
}

TEST(StandingLight, IsTakenOutOfThePartsShareAlone) {
  PartByHand part;
  part.standing = [](double, double) { return 10; };
  std::vector<KeptWindow> windows = windows_of(part);
  const PartPictures pictures = part.pictures(1);
  StandingLight light(PartByHand::region, pictures.share);
  for (int round = 0; round < 3; ++round) light.learn(windows, pictures, kInside);
  const Point centre{90.4, 64.7};
  Picture taken(70, 70);
  light.take_out(taken, 55, 30, centre);
  const Picture found = level_of(light);
  double shown = 0;
  for (int y = 0; y < 70; ++y)
    for (int x = 0; x < 70; ++x) {
      if (found.at(55 + x, 30 + y) == 0) continue;  // beyond what level_of() tells
      const double covers = 1 - part.share(55 + x - centre.x, 30 + y - centre.y);
      ASSERT_NEAR(taken.at(x, y), -covers * static_cast<double>(found.at(55 + x, 30 + y)), 0.02)
          << x << " " << y;
      shown += covers;
    }
  EXPECT_GT(shown, 0.9 * std::numbers::pi * part.radius * part.radius);
}

}  // namespace
}  // namespace tribotrack::vision
