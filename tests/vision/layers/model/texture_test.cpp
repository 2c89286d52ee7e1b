#include "vision/layers/model/texture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <tuple>
#include <vector>

#include "vision/layers/part_by_hand.h"

namespace tribotrack::vision {
namespace {

using test::PartByHand;
using test::state_of;

constexpr double kWide = 3;  ///< px: of the marks that turn

/// Re (u + iv)^order, cut by a Gaussian: nothing of it is the same on the whole of a ring.
double harmonic(int order, double u, double v) {
  const double rho = std::hypot(u, v) / kWide, phi = std::atan2(v, u);
  return 8 * std::pow(rho, order) * std::exp(-0.5 * rho * rho) * std::cos(order * phi);
}

double mark(double u, double v) {
  return 20 * std::exp(-0.5 * (std::pow(u - 8, 2) + v * v) / (kWide * kWide));
}

/// Learnt from windows whose angles go from 0 to `turned`, over the part without what turns.
TurningTexture learnt(const PartByHand& part, double turned, bool turned_round) {
  std::mt19937 random(1);
  std::vector<KeptWindow> windows;
  for (int k = 0; k < 48; ++k) {
    LayeredState s = state_of(k);
    s.theta = turned * k / 47;
    s.gain = s.ground_gain = 1 + 0.1 * std::sin(k);
    windows.push_back(part.window(s, part.half + 6, 0, random));
  }
  TurningTexture out(part.half, part.radius, part.blur, turned_round);
  out.learn(test::pointers_to(windows), part.pictures(1), part.ground(1e-4));
  return out;
}

/// act(u, v) on the face, where the texture has not begun to end.
template <class Act>
void on_face(const PartByHand& part, const Act& act) {
  const double reach = part.radius - 3 * part.blur - 2;
  for (int v = -part.half; v <= part.half; ++v)
    for (int u = -part.half; u <= part.half; ++u)
      if (std::hypot(u, v) < reach) act(u, v);
}

TEST(TurningTexture, WhatTurnsIsLearntBack) {
  PartByHand part;
  part.turning = [](double u, double v) { return harmonic(2, u, v); };
  for (const bool round : {false, true}) {
    const TurningTexture texture = learnt(part, round ? 7 : 2, round);
    const Picture t = texture.at(0);
    on_face(part, [&](int u, int v) {
      ASSERT_NEAR(t.at(u + part.half, v + part.half), harmonic(2, u, v), 0.03) << u << " " << v;
    });
  }
}

// What is the same on a ring is the standing picture's, and a slope about the centre that of a light as long
// as the part has not been seen from all sides.
TEST(TurningTexture, FirstHarmonicIsOfAPartThatHasTurnedRight) {
  PartByHand part;
  part.turning = [](double u, double v) {
    return harmonic(1, u, v) + harmonic(2, u, v) + 0.5 * harmonic(0, u, v);
  };
  for (const bool round : {false, true}) {
    const Picture t = learnt(part, round ? 7 : 2, round).at(0);
    on_face(part, [&](int u, int v) {
      const double left = harmonic(2, u, v) + (round ? harmonic(1, u, v) : 0);
      // A ring is a pixel wide: what changes across it is not taken out.
      ASSERT_NEAR(t.at(u + part.half, v + part.half), left, round ? 0.8 : 1.5) << u << " " << v;
    });
    // Exactly none on the whole of a ring.
    for (const int ring : {2, 5, 8, 11}) {
      double sum = 0, along = 0;
      on_face(part, [&](int u, int v) {
        if (std::lround(std::hypot(u, v)) != ring) return;
        sum += static_cast<double>(t.at(u + part.half, v + part.half));
        along += static_cast<double>(t.at(u + part.half, v + part.half)) * u / std::hypot(u, v);
      });
      EXPECT_NEAR(sum, 0, 1e-2) << ring;
      if (round) continue;
      EXPECT_NEAR(along, 0, 1e-2) << ring;
    }
  }
}

// A mark to the right of the centre is above it, at smaller y, after a quarter turn.
TEST(TurningTexture, TurnsCounterClockwiseAsSeen) {
  PartByHand part;
  part.turning = mark;
  const TurningTexture texture = learnt(part, 7, true);
  for (const auto& [turn, x, y] : {std::tuple{0, 8, 0}, {1, 0, -8}, {2, -8, 0}, {3, 0, 8}}) {
    const Picture t = texture.at(turn * std::numbers::pi / 2);
    int at_x = 0, at_y = 0;
    on_face(part, [&](int u, int v) {
      if (t.at(u + part.half, v + part.half) <= t.at(at_x + part.half, at_y + part.half)) return;
      at_x = u;
      at_y = v;
    });
    EXPECT_EQ(at_x, x) << turn;
    EXPECT_EQ(at_y, y) << turn;
  }
}

TEST(TurningTexture, SlopeIsTheDerivativeByTheAngle) {
  PartByHand part;
  part.turning = mark;
  const TurningTexture texture = learnt(part, 7, true);
  constexpr double kStep = 2e-3;
  double steepest = 0;
  for (const double theta : {0.0, 0.7, -2.1, 4.0}) {
    Picture slope;
    texture.at(theta, &slope);
    const Picture after = texture.at(theta + kStep), before = texture.at(theta - kStep);
    on_face(part, [&](int u, int v) {
      const int x = u + part.half, y = v + part.half;
      ASSERT_NEAR(slope.at(x, y), static_cast<double>(after.at(x, y) - before.at(x, y)) / (2 * kStep), 0.05)
          << u << " " << v;
      steepest = std::max(steepest, std::abs(static_cast<double>(slope.at(x, y))));
    });
  }
  EXPECT_GT(steepest, 30);
}

// At a part's rim the ground shows, another at every window, and does not turn with it.
TEST(TurningTexture, GroundSeenAtTheRimIsNone) {
  PartByHand part;
  const TurningTexture texture = learnt(part, 7, true);
  EXPECT_LT(texture.contrast(), 0.02);
}

TEST(TurningTexture, EndsBeforeTheRimOfAPartThatHasNotTurnedRound) {
  PartByHand part;
  part.turning = [](double u, double v) { return std::cos(2 * std::atan2(v, u)); };
  const Picture t = learnt(part, 2, false).at(0.3);
  for (int v = -part.half; v <= part.half; ++v)
    for (int u = -part.half; u <= part.half; ++u)
      if (std::hypot(u, v) >= part.radius - 3 * part.blur) {
        ASSERT_EQ(t.at(u + part.half, v + part.half), 0);
      }
}

}  // namespace
}  // namespace tribotrack::vision
