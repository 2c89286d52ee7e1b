#include "model/lanes/shooting.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/laws.h"
#include "model/processor/instruction_set.h"
#include "model/random_scenario.h"

namespace tribotrack::model::internal {
namespace {

double speed_of(const Scenario& s) {
  return s.drive.amplitude * s.drive.angular_frequency;
}

/// One cycle from that velocity, by the integrator.
struct OneCycle {
  Eigen::Vector2d velocity, displacement;
};
OneCycle cycle_from(Scenario s, const Eigen::Vector2d& velocity) {
  s.start = Start::rest;
  s.initial_velocity = velocity;
  s.cycles = 1;
  IntegrationOptions options;
  options.dense = false;
  const Sample end = integrate(s, options).end();
  return {end.velocity, end.position};
}

/// Spectral radius of the one-cycle map by central differences.
double contraction_by_differences(const Scenario& s, const Eigen::Vector2d& velocity) {
  const double step = 1e-5 * speed_of(s);
  Eigen::Matrix2d map;
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d by = step * Eigen::Vector2d::Unit(k);
    map.col(k) = (cycle_from(s, velocity + by).velocity - cycle_from(s, velocity - by).velocity) / (2 * step);
  }
  const double half = 0.5 * map.trace(), square = half * half - map.determinant();
  return square < 0 ? std::sqrt(map.determinant()) : std::abs(half) + std::sqrt(square);
}

Scenario slider(RandomScenario& random, double most) {
  Scenario s = random.circular();
  const double threshold = speed_of(s) * s.drive.angular_frequency / s.drive.gravity;
  s.friction.nominal = threshold * random.uniform(0.05, most);
  s.friction.reduced = s.friction.nominal * random.uniform(0.02, 0.95);
  s.friction.pulse_width = random.uniform(0.02, 6.26);
  if (random.uniform(0, 1) < 0.5) s.drive.phase_shift *= -1;
  return s;
}

/// In every instruction set the integrator's cycle from the orbit comes back to it, goes as far, and
/// contracts as much.
TEST(Shooting, FindsWhereACycleComesBack) {
  const InstructionSet best = instruction_set();
  int found = 0, tried = 0;
  for (const InstructionSet set : available_instruction_sets()) {
    RandomScenario random(41);
    std::cout << "seed 41\n";
    for (int i = 0; i < 40; ++i, ++tried) {
      const Scenario s = slider(random, 0.98);
      use_instruction_set(set);
      const auto orbit = shoot(s);
      use_instruction_set(best);
      if (!orbit) continue;
      ++found;
      const OneCycle cycle = cycle_from(s, orbit->velocity);
      EXPECT_LT((cycle.velocity - orbit->velocity).norm(), 2e-13 * speed_of(s)) << i;
      EXPECT_LT((cycle.displacement - orbit->drift).norm(), 2e-12 * s.drive.amplitude) << i;
      EXPECT_NEAR(orbit->contraction, contraction_by_differences(s, orbit->velocity), 1e-4) << i;
      EXPECT_EQ(orbit->phase, s.start_phase);
    }
  }
  EXPECT_GT(found, 0.95 * tried);
}

/// Cycles whose first edge, or whose last, is where they begin.
TEST(Shooting, EdgesAtTheStart) {
  for (const double phase : {0.0, -1.2, 1e-13, -1e-13, 2 * laws::kPi - 1.2}) {
    Scenario s;
    s.friction = {0.1, 0.0125, phase, 1.2, 0};
    const auto orbit = shoot(s);
    ASSERT_TRUE(orbit) << phase;
    const OneCycle cycle = cycle_from(s, orbit->velocity);
    EXPECT_LT((cycle.velocity - orbit->velocity).norm(), 1e-13 * speed_of(s)) << phase;
    EXPECT_LT((cycle.displacement - orbit->drift).norm(), 1e-12 * s.drive.amplitude) << phase;
  }
}

/// What lanes cannot carry is left to the one-cycle map.
TEST(Shooting, DeclinesWhatItCannotCarry) {
  Scenario s;
  s.friction = {0.1, 0.0125, 0.5, 1.2, 0};
  ASSERT_TRUE(shoot(s));
  const auto with = [&](auto change) {
    Scenario changed = s;
    change(changed);
    return shoot(changed);
  };
  EXPECT_FALSE(with([](Scenario& t) { t.drive.tilt_x = 1e-3; }));
  EXPECT_FALSE(with([](Scenario& t) { t.drive.amplitude_y *= 1.1; }));
  EXPECT_FALSE(with([](Scenario& t) { t.drive.amplitude = t.drive.amplitude_y = 0; }));
  EXPECT_FALSE(with([](Scenario& t) { t.friction.pulse_width = 0; }));
  EXPECT_FALSE(with([](Scenario& t) { t.friction.nominal = t.friction.reduced; }));
  EXPECT_FALSE(with([](Scenario& t) { t.friction.nominal = t.friction.reduced = 0; }));
  EXPECT_FALSE(with([](Scenario& t) { t.friction.nominal = 0.3; }));  // stops
}

}  // namespace
}  // namespace tribotrack::model::internal
