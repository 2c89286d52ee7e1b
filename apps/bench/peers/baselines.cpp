#include "apps/bench/peers/baselines.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "apps/bench/peers/dormand_prince.h"

namespace tribotrack::bench {

using namespace model;

namespace {

void check(const Scenario& scenario) {
  scenario.validate();
  if (scenario.start != Start::rest)
    throw std::invalid_argument("the peers integrate from rest or an initial velocity only");
}

}  // namespace

DormandPrinceOptions paper_recipe() {
  DormandPrinceOptions options;
  options.max_step = 1e-4;
  return options;
}

DormandPrinceOptions segmented_dormand_prince(const Scenario& scenario, double tolerance) {
  const double length = std::max(scenario.drive.amplitude, scenario.drive.amplitude_y);
  DormandPrinceOptions options;
  options.relative_tolerance = tolerance;
  options.position_tolerance = tolerance * length;
  options.velocity_tolerance = tolerance * length * scenario.drive.angular_frequency;
  options.segmented = true;
  // Within some tolerances of zero an explicit method no longer knows the direction and chatters; below 1e-10
  // of A w the rest of the path is nothing, but its steps get lost against t.
  options.stop_speed = std::max(30 * tolerance, 1e-10) * length * scenario.drive.angular_frequency;
  return options;
}

PeerResult dormand_prince(const Scenario& scenario, const DormandPrinceOptions& options) {
  check(scenario);
  return DormandPrince<double>(scenario, options).run();
}

PeerResult extended_precision_reference(const Scenario& scenario, double tolerance) {
  check(scenario);
  DormandPrinceOptions options = segmented_dormand_prince(scenario, tolerance);
  options.max_steps = 50'000'000;
  return DormandPrince<long double>(scenario, options).run();
}

PeerResult moreau_jean(const Scenario& scenario, double step) {
  check(scenario);
  const PlainEquation<double> f(scenario);
  const auto count = static_cast<long>(std::ceil(f.end() / step));
  const double h = f.end() / static_cast<double>(count);
  PeerResult result;
  Eigen::Vector2d x = Eigen::Vector2d::Zero(), u = scenario.initial_velocity;
  for (long k = 0; k < count; ++k) {
    const double t = static_cast<double>(k + 1) * h;
    Eigen::Vector2d d;
    f.drive(t, d.x(), d.y());
    u += h * d;
    // What the friction impulse, at most h m, leaves of the free velocity.
    const double speed = u.norm(), impulse = h * f.friction(t);
    u *= speed > impulse ? 1 - impulse / speed : 0;
    x += h * u;
  }
  result.position = x;
  result.velocity = u;
  result.steps = count;
  result.finished = true;
  return result;
}

}  // namespace tribotrack::bench
