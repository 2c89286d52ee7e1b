#include "apps/bench/model.h"

#include <gtest/gtest.h>

#include "model/reference_error.h"
#include "model/trajectory.h"

namespace tribotrack::model {

using bench::extreme_cases;
using bench::ExtremeCase;

namespace {

constexpr bool kQuick = true;

TEST(Extremes, EachAgreesWithQuadruplePrecision) {
  for (const ExtremeCase& c : extreme_cases(kQuick)) {
    SCOPED_TRACE(c.name);
    const Scenario& s = c.scenario;
    EXPECT_LT(s.cycles > 24 ? reference::difference(integrate(s), reference::after_many_cycles(s))
                            : reference::error_against_reference(s),
              1e-11);
  }
}

/// A million cycles: the reference adds cycles in quadruple precision.
TEST(Extremes, AMillionCyclesAgreeWithQuadruplePrecision) {
  for (const ExtremeCase& c : extreme_cases(kQuick)) {
    if (c.scenario.cycles != 100) continue;
    SCOPED_TRACE(c.name);
    Scenario s = c.scenario;
    s.cycles = 1e6;
    EXPECT_LT(reference::difference(integrate(s), reference::after_many_cycles(s)), 1e-11);
  }
}

TEST(Extremes, DerivativesAreFiniteAndDoNotDisturbTheMotion) {
  IntegrationOptions options;
  for (int p = 0; p <= static_cast<int>(Parameter::start_phase); ++p)
    options.derivatives.push_back(static_cast<Parameter>(p));
  for (const ExtremeCase& c : extreme_cases(kQuick)) {
    SCOPED_TRACE(c.name);
    const Trajectory plain = integrate(c.scenario), differentiated = integrate(c.scenario, options);
    const SensitiveSample end = differentiated.sensitive_end();
    EXPECT_TRUE(end.position_jacobian.allFinite());
    EXPECT_TRUE(end.velocity_jacobian.allFinite());
    EXPECT_LE((plain.end().position - end.sample.position).norm(), 1e-11 * reference::path_size(plain));
  }
}

TEST(Extremes, NoneNeedsFiftyTimesTheStepsOfTheOrdinaryCase) {
  const auto cases = extreme_cases(kQuick);
  const auto steps_per_cycle = [](const Scenario& s) {
    const double cycles = s.end_time() * s.drive.angular_frequency / (2 * std::numbers::pi);
    return static_cast<double>(integrate(s).summary().steps) / std::max(1.0, cycles);
  };
  const double ordinary = steps_per_cycle(cases.front().scenario);
  for (const ExtremeCase& c : cases) EXPECT_LT(steps_per_cycle(c.scenario), 50 * ordinary) << c.name;
}

}  // namespace
}  // namespace tribotrack::model
