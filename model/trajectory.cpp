#include "model/trajectory.h"

#include <algorithm>
#include <cstdio>

#include "model/run/solved_run.h"
#include "model/run/spin_run.h"

namespace tribotrack::model {

std::string IntegrationSummary::brief_report() const {
  char text[200];
  std::snprintf(text, sizeof text, "%ld steps, %d stops, %d releases, %.3g s (%.3g %%) at rest", steps, stops,
                releases, stick_time, 100 * sticking_fraction);
  return text;
}

Trajectory::Trajectory(std::shared_ptr<const Implementation> implementation)
    : implementation_(std::move(implementation)) {}

const Scenario& Trajectory::scenario() const {
  return implementation_->scenario;
}
const IntegrationSummary& Trajectory::summary() const {
  return implementation_->summary;
}
Sample Trajectory::at(double time) const {
  return implementation_->at(time, true).sample;
}
SensitiveSample Trajectory::sensitive_at(double time) const {
  return implementation_->at(time, true);
}
SensitiveSample Trajectory::sensitive_end() const {
  return implementation_->at(end_time(), scenario().duration > 0);
}
void Trajectory::positions_at(const std::vector<double>& times, double exposure, Eigen::Matrix2Xd& positions,
                              Eigen::MatrixXd* jacobian) const {
  const auto count = static_cast<Eigen::Index>(times.size());
  positions.resize(2, count);
  if (jacobian)
    jacobian->resize(2 * count, static_cast<Eigen::Index>(implementation_->options.derivatives.size()));
  for (Eigen::Index k = 0; k < count; ++k) {
    const SensitiveSample there = implementation_->at(times[static_cast<std::size_t>(k)], true);
    positions.col(k) = there.sample.position + exposure * exposure / 24 * there.sample.acceleration;
    if (jacobian) jacobian->middleRows<2>(2 * k) = there.position_jacobian;
  }
}

namespace {

using internal::Jet;

template <template <class> class Solved>
std::unique_ptr<Trajectory::Implementation> solve(const Scenario& scenario,
                                                  const IntegrationOptions& options) {
  const size_t n = options.derivatives.size();
  if (n == 0) return std::make_unique<Solved<double>>(scenario, options);
  if (n <= 4) return std::make_unique<Solved<Jet<4>>>(scenario, options);
  if (n <= 8) return std::make_unique<Solved<Jet<8>>>(scenario, options);
  if (n <= 16) return std::make_unique<Solved<Jet<16>>>(scenario, options);
  throw std::invalid_argument("derivatives: at most 16 parameters at a time");
}

/// A part without spin or viscous friction may be asked for its derivative by them.
bool as_spinning_slide(const Scenario& scenario, const IntegrationOptions& options) {
  const auto asked = [&](Parameter parameter) {
    return std::ranges::count(options.derivatives, parameter) > 0;
  };
  return scenario.spin.rate != 0 || scenario.viscous != 0 || asked(Parameter::viscous) ||
         (scenario.spin.radius > 0 && asked(Parameter::spin));
}

}  // namespace

Trajectory integrate(const Scenario& scenario, const IntegrationOptions& options) {
  scenario.validate();
  if (!(options.tolerance > 0 && options.tolerance < 0.1))
    throw std::invalid_argument("tolerance = " + std::to_string(options.tolerance) + " must be in (0, 0.1)");
  return Trajectory(as_spinning_slide(scenario, options) ? solve<internal::SpinRun>(scenario, options)
                                                         : solve<internal::Run>(scenario, options));
}

}  // namespace tribotrack::model
