// The end of a run from its first cycles against the whole run.
#include "fit/internal/settled_end.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tribotrack::fit::internal {
namespace {

constexpr double pi = std::numbers::pi;

TEST(SettledEnd, IsTheEndOfTheWholeRunToWithinTheTolerance) {
  int shortened = 0;
  for (const double mu1 : {0.03, 0.06, 0.1, 0.122})
    for (const double dtau : {0.4, pi / 2, 5.0})
      for (const double cycles : {3.0, 20.0, 20.3, 60.0}) {
        model::Scenario scenario;
        scenario.friction = {mu1, mu1 / 8, 0.7, dtau, 0.1};
        scenario.drive.tilt_x = 0.001;
        scenario.duration = cycles * 2 * pi / scenario.drive.angular_frequency;
        model::IntegrationOptions options;
        options.derivatives = {model::Parameter::mu1, model::Parameter::mu2, model::Parameter::lag,
                               model::Parameter::angular_frequency, model::Parameter::tilt_x};
        const model::SensitiveSample whole = model::integrate(scenario, options).sensitive_end();
        for (const double tolerance : {1e-4, 1e-7, 1e-10}) {
          options.tolerance = tolerance;
          const EndPoint end = settled_end(scenario, options);
          shortened += end.cycles < cycles - 1;
          EXPECT_LT((end.position - whole.sample.position).norm(),
                    10 * tolerance * whole.sample.position.norm())
              << mu1 << " " << dtau << " " << cycles << " " << tolerance;
          for (Eigen::Index j = 0; j < 5; ++j)
            EXPECT_LT((end.jacobian - whole.position_jacobian).col(j).norm(),
                      100 * tolerance * whole.position_jacobian.col(j).norm())
                << mu1 << " " << dtau << " " << cycles << " " << tolerance << " column " << j;
        }
      }
  EXPECT_GT(shortened, 40);
}

TEST(SettledEnd, WithoutFrictionNothingSettles) {
  model::Scenario scenario;
  scenario.friction = {0.02, 0, 0.7, 6.2, 0.1};
  scenario.cycles = 30;
  model::IntegrationOptions options;
  options.tolerance = 1e-8;
  const Eigen::Vector2d whole = model::integrate(scenario).end().position;
  EXPECT_LT((settled_end(scenario, options).position - whole).norm(), 1e-6 * whole.norm());
}

}  // namespace
}  // namespace tribotrack::fit::internal
