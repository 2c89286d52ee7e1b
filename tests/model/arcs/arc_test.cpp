// The collocated arcs: instruction sets, dense output inside them, tolerances.
#include "model/arcs/arc.h"

#include <gtest/gtest.h>

#include <iostream>
#include <random>

#include "model/laws.h"
#include "model/processor/instruction_set.h"
#include "model/random_scenario.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

using internal::InstructionSet;
using laws::kPi;

Scenario reference_run() {
  Scenario s;
  s.friction = {0.1, 0.0125, 0.5, kPi / 2, 0};
  return s;
}

/// Scenarios of every kind, some sticking, some not.
std::vector<Scenario> scenarios(unsigned seed, int count) {
  RandomScenario random(seed);
  std::vector<Scenario> all = {reference_run()};
  for (int i = 0; i < count; ++i) {
    all.push_back(random.circular());
    all.push_back(random.general());
  }
  return all;
}

double size_of(const Scenario& s, const Eigen::Vector2d& x) {
  return std::max({x.norm(), s.drive.amplitude, s.drive.amplitude_y});
}

/// Puts the instruction set back.
struct WithSet {
  explicit WithSet(InstructionSet set) { internal::use_instruction_set(set); }
  ~WithSet() { internal::use_instruction_set(before); }
  WithSet(const WithSet&) = delete;
  WithSet& operator=(const WithSet&) = delete;
  InstructionSet before = internal::instruction_set();
};

TEST(Arc, InstructionSetsAgree) {
  const std::vector<Parameter> all = {Parameter::mu1,         Parameter::mu2,         Parameter::lag,
                                      Parameter::phi,         Parameter::dtau,        Parameter::amplitude,
                                      Parameter::amplitude_y, Parameter::phase_shift, Parameter::gravity};
  for (const Scenario& s : scenarios(20210, 10))
    for (const size_t derivatives : {0, 3, 8, 9})
      for (const double tolerance : {1e-16, 1e-5}) {
        IntegrationOptions options;
        options.tolerance = tolerance;
        options.dense = false;
        options.derivatives.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(derivatives));
        const auto end = [&](InstructionSet set) {
          const WithSet with(set);
          return integrate(s, options).sensitive_end();
        };
        const SensitiveSample plain = end(InstructionSet::baseline);
        for (const InstructionSet set : internal::available_instruction_sets()) {
          SCOPED_TRACE(to_string(set));
          const SensitiveSample other = end(set);
          EXPECT_LT((other.sample.position - plain.sample.position).norm(),
                    1e-12 * size_of(s, plain.sample.position));
          for (Eigen::Index j = 0; j < plain.position_jacobian.cols(); ++j) {
            const Eigen::Vector2d a = plain.position_jacobian.col(j), b = other.position_jacobian.col(j);
            EXPECT_LE((a - b).norm(), 1e-10 * a.norm() + 1e-12 * size_of(s, plain.sample.position)) << j;
          }
        }
      }
}

TEST(Arc, OnlyTheEndIsKnownOfARunThatIsNotDense) {
  IntegrationOptions options;
  options.dense = false;
  const Trajectory t = integrate(reference_run(), options);
  EXPECT_THROW(t.at(0.5 * t.end_time()), std::logic_error);
}

/// What dense output says of a time is what a run that ends there says.
TEST(Arc, DenseOutputInsideArcs) {
  for (const double nominal : {0.05, 0.1, 0.122}) {
    Scenario s = reference_run();
    s.friction.nominal = nominal;
    s.drive.tilt_x = 0.002;
    s.cycles = 3;
    IntegrationOptions options;
    options.derivatives = {Parameter::mu1, Parameter::lag, Parameter::amplitude};
    const Trajectory dense = integrate(s, options);
    options.dense = false;
    for (int i = 1; i < 40; ++i) {
      Scenario part = s;
      part.duration = dense.end_time() * i / 40.3;
      const SensitiveSample inside = dense.sensitive_at(part.duration);
      const SensitiveSample end = integrate(part, options).sensitive_at(part.duration);
      EXPECT_LT((inside.sample.position - end.sample.position).norm(), 1e-13 * s.drive.amplitude);
      EXPECT_LT((inside.sample.velocity - end.sample.velocity).norm(),
                1e-13 * s.drive.amplitude * s.drive.angular_frequency);
      EXPECT_LE((inside.position_jacobian - end.position_jacobian).norm(),
                1e-10 * end.position_jacobian.norm());
    }
  }
}

/// Tolerances are kept: the error of a slipping run stays below the tolerance for each of its cycles.
TEST(Arc, ErrorsFollowTheTolerance) {
  for (const double nominal : {0.03, 0.05, 0.1}) {
    Scenario s = reference_run();
    s.friction.nominal = nominal;
    const Eigen::Vector2d exact = integrate(s).end().position;
    for (double tolerance = 1e-3; tolerance > 1e-15; tolerance *= 0.1)
      for (const bool dense : {false, true}) {
        IntegrationOptions options;
        options.tolerance = tolerance;
        options.dense = dense;
        options.reuse_repeating_cycles = false;
        EXPECT_LT((integrate(s, options).end().position - exact).norm(),
                  2 * kPi * s.cycles * tolerance * s.drive.amplitude + 1e-15 * exact.norm())
            << "mu1 " << nominal << " tolerance " << tolerance;
      }
  }
}

}  // namespace
}  // namespace tribotrack::model
