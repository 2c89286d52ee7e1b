// Where a part goes in 20 turns of the platform under the source paper's conditions, and how that depends on
// its friction. Use: simulate
#include <cstdio>
#include <numbers>

#include "model/alpha_v.h"
#include "model/trajectory.h"

int main() {
  using namespace tribotrack::model;
  constexpr double pi = std::numbers::pi;

  Scenario scenario;  // A = 0.28 mm, w = 62.8 rad/s, from rest; everything in SI units
  scenario.friction = {.nominal = 0.1, .reduced = 0.0125, .phase = pi / 2, .pulse_width = pi / 3};
  scenario.cycles = 20;

  IntegrationOptions options;
  options.derivatives = {Parameter::mu1, Parameter::mu2};
  const Trajectory run = integrate(scenario, options);

  std::printf("   t (s)    x (mm)    y (mm)\n");
  for (int cycle = 0; cycle <= 20; cycle += 5) {
    const Sample at = run.at(run.end_time() * cycle / 20);
    std::printf("%8.4f  %8.4f  %8.4f  %s\n", at.time, 1e3 * at.position.x(), 1e3 * at.position.y(),
                at.state == State::stick ? "sticks" : "slips");
  }

  const Eigen::Vector2d moved = run.end().position;
  std::printf("alpha = %.4f rad, v = %.3f mm/s\n", displacement_angle(moved),
              1e3 * mean_velocity(moved, run.end_time()));

  // One column for each parameter. Exact derivatives: no second run with slightly more friction.
  const Eigen::Matrix2Xd slopes = run.sensitive_end().position_jacobian;
  std::printf("1 %% more mu1 moves the end by (%.4f, %.4f) mm, 1 %% more mu2 by (%.4f, %.4f) mm\n",
              1e3 * slopes(0, 0) * 0.001, 1e3 * slopes(1, 0) * 0.001, 1e3 * slopes(0, 1) * 0.000125,
              1e3 * slopes(1, 1) * 0.000125);
}
