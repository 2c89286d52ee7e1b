// The collocated arcs: dense output inside them, tolerances.
#include "model/arcs/arc.h"

#include <gtest/gtest.h>

#include "model/laws.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

using laws::kPi;
using laws::reference_run;

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
