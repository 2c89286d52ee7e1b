#include "model/friction.h"

#include <gtest/gtest.h>

#include <numbers>

namespace tribotrack::model {
namespace {

constexpr double pi = std::numbers::pi;

Friction pulse(double phi, double width) {
  Friction friction;
  friction.phase = phi;
  friction.pulse_width = width;
  friction.lag = 1.0;  // must not matter: the gate is what was commanded
  return friction;
}

TEST(Gate, WholeCyclesAreOnForThePulsesShareOfTheCycle) {
  EXPECT_NEAR(gate_share(pulse(0.3, pi / 3), -7, -7 + 2 * pi), 1.0 / 6, 1e-15);
  EXPECT_NEAR(gate_share(pulse(-37.5, 1), 100, 100 + 6 * pi), 1 / (2 * pi), 1e-14);
}

TEST(Gate, EdgesWithinTheIntervalCountByTheirPart) {
  EXPECT_DOUBLE_EQ(gate_share(pulse(1, 2), 0, 4), 0.5);
  EXPECT_DOUBLE_EQ(gate_share(pulse(1, 2), 0.5, 1.5), 0.5);
  EXPECT_DOUBLE_EQ(gate_share(pulse(1, 2), 1.5, 2.5), 1);
  EXPECT_NEAR(gate_share(pulse(1, 2), 3.5, 6), 0, 1e-15);
}

TEST(Gate, NoPulseIsNeverOnAndAFullOneAlways) {
  EXPECT_DOUBLE_EQ(gate_share(pulse(1, 0), 0, 9), 0);
  EXPECT_NEAR(gate_share(pulse(1, 2 * pi), 0, 9), 1, 1e-15);
}

}  // namespace
}  // namespace tribotrack::model
