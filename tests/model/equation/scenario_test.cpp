// What the equation of motion is made of: drive, friction, gate, and the scenario that holds them.
#include "model/scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "model/plan.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

constexpr double pi = std::numbers::pi;

std::string refusal(const Scenario& s) {
  try {
    s.validate();
  } catch (const InvalidParameter& error) {
    return error.what();
  }
  return "";
}

/// Whoever is handed a bad scenario refuses it by the parameter's name, next to the range's ends too.
TEST(Scenario, EveryEntranceRefuses) {
  const double inf = std::numeric_limits<double>::infinity(), next = std::nextafter(2 * std::numbers::pi, 7);
  const std::vector<std::pair<Parameter, double>> bad = {{Parameter::mu1, -1e-300},
                                                         {Parameter::mu2, -inf},
                                                         {Parameter::dtau, next},
                                                         {Parameter::dtau, -1e-300},
                                                         {Parameter::gravity, 0},
                                                         {Parameter::gravity, -9.81},
                                                         {Parameter::angular_frequency, 0},
                                                         {Parameter::angular_frequency, -62.8},
                                                         {Parameter::amplitude, -1e-300},
                                                         {Parameter::amplitude_y, -inf},
                                                         {Parameter::phi, inf},
                                                         {Parameter::lag, -inf},
                                                         {Parameter::phase_shift, inf},
                                                         {Parameter::tilt_x, inf},
                                                         {Parameter::tilt_y, std::nan("")},
                                                         {Parameter::velocity_x, inf},
                                                         {Parameter::start_phase, std::nan("")}};
  for (const auto& [wrong, value] : bad) {
    Scenario s;
    s.set(wrong, value);
    // Named anew: clang before 16 takes no structured binding into a lambda.
    const auto refuses = [parameter = wrong](auto&& entrance) {
      try {
        entrance();
        ADD_FAILURE() << to_string(parameter) << " was accepted";
      } catch (const InvalidParameter& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr(to_string(parameter)));
      }
    };
    refuses([&] { integrate(s); });
    refuses([&] { steady_orbit(s); });
    refuses([&] { plan(s); });
  }
  for (const double cycles : {-1.0, inf, std::nan("")}) {
    Scenario s;
    s.cycles = cycles;
    EXPECT_THAT(refusal(s), testing::HasSubstr("cycles"));
    s = Scenario{};
    s.duration = cycles;
    EXPECT_THAT(refusal(s), testing::HasSubstr("duration"));
  }
}

TEST(Scenario, LegalExtremes) {
  for (const double dtau : {0.0, 2 * std::numbers::pi}) {
    Scenario s;
    s.friction = {0, 0, 1e6, dtau, -1e6};
    s.drive.amplitude = s.drive.amplitude_y = 0;
    EXPECT_EQ(integrate(s).end().position.norm(), 0);
  }
}

/// In the platform's frame the part feels minus the platform's acceleration, and gravity's share in the
/// plane.
TEST(Drive, IsMinusThePlatformsAcceleration) {
  Drive d;
  d.amplitude_y = 0.2e-3;
  d.phase_shift = 0.7;
  const double w = d.angular_frequency, h = 1e-3;
  for (const double phase : {0.0, 1.0, 4.0}) {
    const Eigen::Vector2d second =
        (d.displacement(phase + h) - 2 * d.displacement(phase) + d.displacement(phase - h)) / (h * h) * w * w;
    EXPECT_LT((d.acceleration(phase) + second).norm(), 1e-6);
  }
  d.tilt_x = 0.1;
  d.tilt_y = -0.2;
  Drive level = d;
  level.tilt_x = level.tilt_y = 0;
  const Eigen::Vector2d gravity = d.acceleration(1.0) - level.acceleration(1.0);
  EXPECT_NEAR(gravity.x(), 9.81 * std::sin(0.1), 1e-15);
  EXPECT_NEAR(gravity.y(), -9.81 * std::sin(0.2), 1e-15);
}

TEST(Friction, ReducedInsideThePulseOnly) {
  const Friction f{0.3, 0.1, 0.5, 1.0, 0.25};
  for (const double turn : {0.0, 2 * pi, -2 * pi, 200 * pi}) {
    EXPECT_EQ(f.coefficient(turn + 0.74), 0.3);
    EXPECT_EQ(f.coefficient(turn + 0.76), 0.1);
    EXPECT_EQ(f.coefficient(turn + 1.74), 0.1);
    EXPECT_EQ(f.coefficient(turn + 1.76), 0.3);
  }
}

TEST(Friction, OnAnEdgeTheValueJustAfter) {
  const Friction f{0.3, 0.1, 0.5, 1.0, 0};
  EXPECT_EQ(f.coefficient(0.5), 0.1);
  EXPECT_EQ(f.coefficient(1.5), 0.3);
}

TEST(Friction, ZeroAndFullWidth) {
  for (const double phase : {0.0, 0.1, 3.0, 6.2}) {
    EXPECT_EQ((Friction{0.3, 0.1, 0.5, 0, 0}.coefficient(phase)), 0.3);
    EXPECT_EQ((Friction{0.3, 0.1, 0.5, 2 * pi, 0}.coefficient(phase)), 0.1);
  }
}

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
