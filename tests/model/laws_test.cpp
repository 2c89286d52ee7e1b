// Every exact law, applied at ordinary, tiny and random parameters.
#include <gtest/gtest.h>

#include <random>

#include "model/laws.h"
#include "model/laws_cycles.h"
#include "model/random_scenario.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

using laws::kPi;
using laws::reference_run;

Scenario tiny_run() {
  Scenario s = reference_run();
  s.drive.amplitude = s.drive.amplitude_y = 3e-9;
  s.drive.angular_frequency = 2e4;
  const double a = laws::drive_amplitude(s);
  s.friction.nominal = 0.4 * a / s.drive.gravity;
  s.friction.reduced = 0.1 * a / s.drive.gravity;
  return s;
}

double friction_over_drive(const Scenario& s) {
  return s.friction.nominal * s.drive.gravity / laws::drive_amplitude(s);
}

/// The ordinary and the tiny run and so many random ones with a circular drive, from a printed seed.
std::vector<Scenario> scenarios(unsigned seed, int count) {
  RandomScenario random(seed);
  std::vector<Scenario> list = {reference_run(), tiny_run()};
  for (int i = 0; i < count; ++i) list.push_back(random.circular());
  return list;
}

/// Every law that holds however a run is integrated, for so many random scenarios. Returns how many points
/// of the energy's balance were compared.
int expect_laws(unsigned seed, int count, const IntegrationOptions& how) {
  RandomScenario random(seed);
  int compared = 0;
  for (const Scenario& s : scenarios(seed, count)) {
    SCOPED_TRACE("m/a = " + std::to_string(friction_over_drive(s)));
    if (friction_over_drive(s) < 0.98) {
      laws::steady_sliding(s, 1e-11, how);
      laws::return_to_steady_sliding(s, 1e-11, how);
    }
    laws::scaling(s, 3, 1e-11, how);
    laws::frictionless_drift(s, 1e-13, how);
    const double speed = laws::drive_amplitude(s) / s.drive.angular_frequency;
    laws::contraction(s, speed * Eigen::Vector2d(0.3, -0.8), how);
    if (how.dense) compared += laws::energy(s, 1e-11, how);
  }
  for (int i = 0; i < count; ++i) {
    const Scenario s = random.general();
    laws::frictionless_motion(s, 1e-12, how);
    const double speed = laws::drive_amplitude(s) / s.drive.angular_frequency;
    laws::contraction(s, speed * Eigen::Vector2d(random.uniform(-1, 1), random.uniform(-1, 1)), how);
    if (how.dense) compared += laws::energy(s, 1e-11, how);
    if (s.drive.tilt_x != 0) continue;  // its pull does not scale with the drive
    laws::scaling(s, 2, 1e-11, how);
    laws::scaling(s, 0.1, 1e-11, how);
  }
  for (const double mu : {0.12, 0.2, 0.4, 3.0}) {
    Scenario s = reference_run();
    s.friction.nominal = mu;
    s.friction.pulse_width = kPi / 6;
    laws::stick_wipes_every_bit(s, how);
    s.cycles = 9;
    if (how.dense) laws::stick_repeats(s, how);
  }
  return compared;
}

class Laws : public testing::Test {
 protected:
  const unsigned seed = std::random_device{}();
  testing::ScopedTrace trace{__FILE__, __LINE__, "seed " + std::to_string(seed)};
};

/// Every way to integrate that is offered to users: dense or not, with repeating cycles or without.
TEST_F(Laws, HoldHoweverIntegrated) {
  for (const bool dense : {true, false})
    for (const bool reuse : {true, false}) {
      SCOPED_TRACE(std::string(dense ? "dense" : "ends") + (reuse ? ", reuse" : ""));
      IntegrationOptions how;
      how.dense = dense;
      how.reuse_repeating_cycles = reuse;
      const int compared = expect_laws(seed, dense && reuse ? 30 : 8, how);
      EXPECT_GT(compared, dense ? 200 : -1);
    }
}

TEST_F(Laws, Rotation) {
  RandomScenario random(seed + 1);
  for (const Scenario& s : scenarios(seed, 20)) {
    SCOPED_TRACE("m/a = " + std::to_string(friction_over_drive(s)));
    laws::rotation(s, random.uniform(-4, 4), 1e-11);
  }
}

TEST_F(Laws, WeakPulsesInTheLimit) {
  laws::weak_pulse(reference_run());
  laws::weak_pulse(tiny_run());
  RandomScenario random(seed);
  for (int i = 0; i < 10; ++i) {
    Scenario s = random.circular();
    s.friction.nominal = random.uniform(0.3, 0.9) * laws::drive_amplitude(s) / s.drive.gravity;
    s.friction.pulse_width = random.uniform(0.3, 5);
    SCOPED_TRACE("m/a = " + std::to_string(friction_over_drive(s)));
    laws::weak_pulse(s);
  }
}

}  // namespace
}  // namespace tribotrack::model
