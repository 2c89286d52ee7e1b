#include "model/batch.h"

#include <gtest/gtest.h>

#include <cstring>

#include "model/laws.h"
#include "model/processor/instruction_set.h"
#include "model/random_scenario.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

using laws::kPi;

constexpr unsigned kSeed = 20;

/// What people sweep: the paper's platform, all frictions from always sliding to always held.
std::vector<Scenario> typical_sweep(int count, unsigned seed = kSeed) {
  std::cout << "seed " << seed << "\n";
  RandomScenario random(seed);
  std::vector<Scenario> scenarios(static_cast<std::size_t>(count));
  for (Scenario& s : scenarios) {
    s.friction.nominal = random.uniform(0.02, 0.25);
    s.friction.reduced = s.friction.nominal * random.uniform(0.02, 1);
    s.friction.phase = random.uniform(0, 2 * kPi);
    s.friction.pulse_width = random.uniform(0.05, 6.2);
  }
  return scenarios;
}

/// Any circular drive, friction larger in the pulse as well, parts that start in motion or circling.
std::vector<Scenario> wide_sweep(int count) {
  std::cout << "seed " << kSeed << "\n";
  RandomScenario random(kSeed);
  std::vector<Scenario> scenarios;
  for (int i = 0; i < count; ++i) {
    Scenario s = random.circular();
    if (i % 3 == 0) s.drive.phase_shift = -s.drive.phase_shift;
    if (i % 4 == 0) std::swap(s.friction.nominal, s.friction.reduced);
    const double speed = laws::drive_amplitude(s) / s.drive.angular_frequency;
    if (i % 5 == 0) s.initial_velocity = {speed * random.uniform(-1, 1), speed * random.uniform(-1, 1)};
    if (i % 7 == 0) s.start = Start::circling;
    s.cycles = i % 2 == 0 ? random.uniform(0, 6) : 20;
    if (i % 6 == 0) s.duration = s.end_time() * random.uniform(0.1, 1);
    scenarios.push_back(s);
  }
  return scenarios;
}

BatchOptions both() {
  BatchOptions options;
  options.steady = true;
  return options;
}

/// 1e-11 of the displacement, and where the part hardly gets anywhere 1e-12 of the drive's amplitude for each
/// cycle.
void expect_same(const Scenario& s, const Eigen::Vector2d& a, const Eigen::Vector2d& b, double cycles) {
  EXPECT_LE((a - b).norm(), 1e-11 * b.norm() + 1e-12 * s.drive.amplitude * std::max(1.0, cycles))
      << "mu1 " << s.friction.nominal << " mu2 " << s.friction.reduced << " phi " << s.friction.phase
      << " dtau " << s.friction.pulse_width << " A " << s.drive.amplitude << " w "
      << s.drive.angular_frequency;
}

void expect_as_by_integrator(const std::vector<Scenario>& scenarios, const BatchOutcome& outcome) {
  ASSERT_EQ(outcome.ends.size(), scenarios.size());
  ASSERT_EQ(outcome.steady.size(), scenarios.size());
  IntegrationOptions options;
  options.dense = false;
  for (std::size_t k = 0; k < scenarios.size(); ++k) {
    const Scenario& s = scenarios[k];
    const BatchEnd& end = outcome.ends[k];
    ASSERT_EQ(end.status, BatchStatus::done);
    const Eigen::Vector2d position = integrate(s, options).end().position;
    expect_same(s, end.position, position, s.end_time() * s.drive.angular_frequency / (2 * kPi));
    EXPECT_DOUBLE_EQ(end.v, end.position.norm() / s.end_time());
    if (end.position.norm() > 0) {
      const double direction = std::atan2(end.position.y(), end.position.x());
      EXPECT_NEAR(std::remainder(end.alpha - direction, 2 * kPi), 0, 1e-15);
    }
    const BatchSteady& steady = outcome.steady[k];
    const auto orbit = steady_orbit(s);
    ASSERT_EQ(steady.status, orbit ? BatchStatus::done : BatchStatus::no_steady_motion);
    if (!orbit) continue;
    expect_same(s, steady.drift, orbit->drift, 1);
    EXPECT_NEAR(steady.v, orbit->mean_velocity(s.drive.angular_frequency),
                1e-11 * steady.v + 1e-12 * s.drive.amplitude * s.drive.angular_frequency);
  }
}

/// No or hardly any friction in the pulse, pulses next to nothing or next to all of the cycle, friction next
/// to its threshold, friction that hardly brakes, fast and slow starts.
std::vector<Scenario> corners(int count) {
  std::cout << "seed " << kSeed << "\n";
  RandomScenario random(kSeed);
  std::vector<Scenario> scenarios;
  for (int i = 0; i < count; ++i) {
    Scenario s = random.circular();
    Friction& f = s.friction;
    const double a = laws::drive_amplitude(s), held = a / s.drive.gravity;
    const auto nearly = [&] { return held * (1 + random.uniform(-1, 1) * random.log_uniform(1e-9, 0.1)); };
    switch (i % 8) {
      case 0:
        f.reduced = 0;
        break;
      case 1:
        f.reduced = f.nominal * 1e-6;
        break;
      case 2:
        f.pulse_width = random.log_uniform(1e-9, 0.1);
        break;
      case 3:
        f.pulse_width = 2 * kPi - random.log_uniform(1e-9, 0.1);
        break;
      case 4:
        f.nominal = nearly();
        break;
      case 5:
        f.nominal = held * random.uniform(0.5, 2.5);
        f.reduced = nearly();
        break;
      case 6:
        f.nominal = held * random.log_uniform(1e-4, 1);
        f.reduced = f.nominal * random.uniform(0, 2);
        break;
      default: {
        const double speed = a / s.drive.angular_frequency * random.log_uniform(1e-6, 10);
        s.initial_velocity = {speed * random.uniform(-1, 1), speed * random.uniform(-1, 1)};
      }
    }
    s.cycles = i % 3 == 0 ? 20 : i % 3 == 1 ? random.uniform(0, 4) : 200;
    scenarios.push_back(s);
  }
  return scenarios;
}

TEST(Batch, IsTheScalarIntegratorInEveryInstructionSet) {
  const auto best = internal::instruction_set();
  for (const auto& [scenarios, share_in_lanes] :
       {std::pair{typical_sweep(300), 0.95}, {wide_sweep(300), 0.9}, {corners(240), 0.8}})
    for (const auto set : internal::available_instruction_sets()) {
      SCOPED_TRACE(internal::to_string(set));
      internal::use_instruction_set(set);
      const auto outcome = solve_batch(scenarios, both());
      internal::use_instruction_set(best);
      expect_as_by_integrator(scenarios, outcome);
      EXPECT_EQ(outcome.summary.solutions, 2 * scenarios.size());
      EXPECT_GE(static_cast<double>(outcome.summary.in_lanes),
                share_in_lanes * static_cast<double>(outcome.summary.solutions))
          << outcome.summary.brief_report();
      EXPECT_TRUE(outcome.reasons.empty());
    }
}

/// Every number's bits (NaN is a number here).
template <class Number>
std::uint64_t bits(const Number& number) {
  std::uint64_t image = 0;
  static_assert(sizeof number == sizeof image);
  std::memcpy(&image, &number, sizeof image);
  return image;
}
void expect_identical(const BatchOutcome& a, const BatchOutcome& b, std::size_t at = 0) {
  for (std::size_t k = 0; k < b.ends.size(); ++k) {
    EXPECT_EQ(a.ends[at + k].position, b.ends[k].position);
    EXPECT_EQ(bits(a.ends[at + k].alpha), bits(b.ends[k].alpha));
    EXPECT_EQ(bits(a.ends[at + k].v), bits(b.ends[k].v));
    EXPECT_EQ(a.steady[at + k].drift, b.steady[k].drift);
    EXPECT_EQ(bits(a.steady[at + k].alpha), bits(b.steady[k].alpha));
    EXPECT_EQ(bits(a.steady[at + k].v), bits(b.steady[k].v));
  }
}

TEST(Batch, SameBitsOnAnyNumberOfThreads) {
  const auto scenarios = typical_sweep(500);
  const auto one = solve_batch(scenarios, both());
  for (int threads = 2; threads <= 4; ++threads) {
    BatchOptions options = both();
    options.threads = threads;
    const auto several = solve_batch(scenarios, options);
    expect_identical(one, several);
    EXPECT_EQ(one.summary.in_lanes, several.summary.in_lanes);
  }
}

TEST(Batch, SameBitsInAnyCompany) {
  const auto scenarios = typical_sweep(60);
  const auto together = solve_batch(scenarios, both());
  for (std::size_t k = 0; k < scenarios.size(); k += 7)
    expect_identical(together, solve_batch(std::span(scenarios).subspan(k, 1), both()), k);
}

/// Looser steps leave more, but no more than some hundred times what was asked for.
TEST(Batch, TolerancesAreKept) {
  auto scenarios = typical_sweep(200);
  for (Scenario& s : scenarios) s.friction.nominal = std::min(s.friction.nominal, 0.1);
  const auto tight = solve_batch(scenarios);
  for (const double tolerance : {1e-5, 1e-8}) {
    BatchOptions options;
    options.tolerance = tolerance;
    const auto loose = solve_batch(scenarios, options);
    double largest = 0;
    for (std::size_t k = 0; k < scenarios.size(); ++k) {
      ASSERT_EQ(loose.ends[k].status, BatchStatus::done);
      const double path = scenarios[k].drive.amplitude * 2 * kPi * 20;
      largest = std::max(largest, (loose.ends[k].position - tight.ends[k].position).norm() / path);
    }
    EXPECT_LT(largest, 100 * tolerance);
    EXPECT_GT(largest, 0.01 * tolerance);  // and time is not spent on what was not asked for
  }
}

/// What lanes cannot carry comes from the scalar integrator, to the bit.
TEST(Batch, FallsBackOnTheScalarIntegrator) {
  Scenario base;
  base.friction = {0.1, 0.0125, 0.5, kPi / 2, 0};
  std::vector<Scenario> scenarios(5, base);
  scenarios[0].drive.amplitude_y *= 0.9;
  scenarios[1].drive.tilt_x = 1e-3;
  scenarios[2].drive.phase_shift = 1;
  scenarios[3].start = Start::steady;
  scenarios[4].friction.nominal = laws::drive_amplitude(base) / base.drive.gravity * (1 - 1e-6);
  scenarios[4].friction.phase = 3;
  const auto outcome = solve_batch(scenarios, both());
  IntegrationOptions options;
  options.dense = false;
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_EQ(outcome.ends[k].position, integrate(scenarios[k], options).end().position);
    if (k < 3) {
      EXPECT_EQ(outcome.steady[k].drift, steady_orbit(scenarios[k])->drift);
    }
  }
  EXPECT_EQ(outcome.summary.in_lanes, 2u) << "what run 3 and 4 settle into";
}

/// Without pulses the part settles on a circle; held, it stays where it is and has no direction.
TEST(Batch, RestAndConstantFriction) {
  Scenario held;
  held.friction = {0.3, 0.2, 0, 1, 0};
  Scenario constant;
  constant.friction = {0.1, 0.1, 0, 1, 0};
  Scenario still = constant;
  still.cycles = 0;
  const auto outcome = solve_batch(std::vector{held, constant, still}, both());
  EXPECT_EQ(outcome.ends[0].position.norm(), 0);
  EXPECT_EQ(outcome.ends[0].v, 0);
  EXPECT_TRUE(std::isnan(outcome.ends[0].alpha));
  EXPECT_EQ(outcome.steady[0].drift.norm(), 0);
  EXPECT_TRUE(std::isnan(outcome.steady[0].alpha));
  IntegrationOptions options;
  options.dense = false;
  expect_same(constant, outcome.ends[1].position, integrate(constant, options).end().position, 20);
  EXPECT_LT(outcome.steady[1].drift.norm(), 1e-12 * constant.drive.amplitude);
  EXPECT_EQ(outcome.ends[2].position.norm(), 0);
}

TEST(Batch, OneBadScenarioSpoilsNoOther) {
  Scenario good;
  good.friction = {0.1, 0.0125, 0.5, kPi / 2, 0};
  Scenario negative = good, frictionless = good, circling = good;
  negative.friction.nominal = -1;
  frictionless.friction.nominal = frictionless.friction.reduced = 0;
  circling.friction.nominal = 0;
  circling.start = Start::circling;
  const auto outcome = solve_batch(std::vector{good, negative, frictionless, circling, good}, both());
  const auto alone = solve_batch(std::vector{good}, both());
  for (const std::size_t k : {0u, 4u}) expect_identical(outcome, alone, k);
  EXPECT_EQ(outcome.ends[1].status, BatchStatus::invalid);
  EXPECT_EQ(outcome.steady[1].status, BatchStatus::invalid);
  EXPECT_EQ(outcome.ends[2].status, BatchStatus::done);
  EXPECT_EQ(outcome.steady[2].status, BatchStatus::no_steady_motion);
  EXPECT_EQ(outcome.ends[3].status, BatchStatus::no_steady_motion);
  EXPECT_EQ(outcome.summary.not_solved, 4u);
  ASSERT_EQ(outcome.reasons.size(), 3u);
  EXPECT_NE(outcome.reasons.at(1).find("mu1 = -1"), std::string::npos);
  EXPECT_NE(outcome.reasons.at(2).find("no unique steady motion"), std::string::npos);
}

TEST(Batch, ScenariosMadeOnDemand) {
  const auto scenarios = typical_sweep(40);
  const auto outcome = solve_batch(
      scenarios.size(),
      [&](std::size_t k) {
        if (k == 3) throw std::runtime_error("cannot make number 3");
        return scenarios[k];
      },
      both());
  EXPECT_EQ(outcome.ends[3].status, BatchStatus::invalid);
  EXPECT_EQ(outcome.reasons.at(3), "cannot make number 3");
  EXPECT_EQ(outcome.ends[4].position, solve_batch(scenarios).ends[4].position);
  EXPECT_TRUE(solve_batch(std::vector<Scenario>{}).ends.empty());
}

TEST(Batch, TellsHowFarItIs) {
  const auto scenarios = typical_sweep(300);
  BatchOptions options = both();
  options.threads = 3;
  std::size_t last = 0, calls = 0;
  options.progress = [&](std::size_t done, std::size_t total) {
    EXPECT_GT(done, last);
    EXPECT_EQ(total, 600u);
    last = done;
    ++calls;
  };
  solve_batch(scenarios, options);
  EXPECT_EQ(last, 600u);
  EXPECT_GT(calls, 10u);
}

}  // namespace
}  // namespace tribotrack::model
