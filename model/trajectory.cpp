#include "model/trajectory.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "model/run/solved_run.h"

namespace tribotrack::model {

std::string IntegrationSummary::brief_report() const {
  char text[200];
  std::snprintf(text, sizeof text, "%ld steps, %d stops, %d releases, %.3g s (%.3g %%) at rest%s", steps,
                stops, releases, stick_time, 100 * sticking_fraction,
                one_sided ? "; derivatives are one-sided (a pulse edge at the start)" : "");
  return text;
}

Trajectory::Trajectory(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
Trajectory::Trajectory(Trajectory&&) noexcept = default;
Trajectory& Trajectory::operator=(Trajectory&&) noexcept = default;
Trajectory::~Trajectory() = default;

const Scenario& Trajectory::scenario() const {
  return implementation_->scenario;
}
const IntegrationSummary& Trajectory::summary() const {
  return implementation_->summary;
}
double Trajectory::end_time() const {
  return implementation_->scenario.end_time();
}
Sample Trajectory::at(double time) const {
  return implementation_->at(time);
}
SensitiveSample Trajectory::sensitive_at(double time) const {
  return implementation_->sensitive_at(time);
}
void Trajectory::positions_at(const std::vector<double>& times, double exposure, Eigen::Matrix2Xd& positions,
                              Eigen::MatrixXd* jacobian) const {
  implementation_->positions_at(times, exposure, positions, jacobian);
}
Sample Trajectory::end() const {
  return implementation_->at(end_time());
}
SensitiveSample Trajectory::sensitive_end() const {
  return implementation_->sensitive_end();
}

Trajectory integrate(const Scenario& scenario, const IntegrationOptions& options) {
  using internal::Jet;
  using internal::Run;
  scenario.validate();
  if (!(options.tolerance > 0 && options.tolerance < 0.1))
    throw std::invalid_argument("tolerance = " + std::to_string(options.tolerance) + " must be in (0, 0.1)");
  const size_t n = options.derivatives.size();
  std::unique_ptr<Trajectory::Implementation> run;
  if (n == 0)
    run = std::make_unique<Run<double>>(scenario, options);
  else if (n <= 4)
    run = std::make_unique<Run<Jet<4>>>(scenario, options);
  else if (n <= 8)
    run = std::make_unique<Run<Jet<8>>>(scenario, options);
  else if (n <= 16)
    run = std::make_unique<Run<Jet<16>>>(scenario, options);
  else
    throw std::invalid_argument("derivatives: at most 16 parameters at a time");
  return Trajectory(std::move(run));
}

}  // namespace tribotrack::model
