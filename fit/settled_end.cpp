#include "fit/internal/settled_end.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tribotrack::fit::internal {
namespace {

using model::Scenario;
using std::numbers::pi;

/// By how much the logarithm of a velocity's deviation falls in one cycle: mu g/(2 U) while sliding at the
/// steady speed U (model: eigenvalues in the rotating frame), weighted by the share of each friction.
double damping_per_cycle(const Scenario& scenario) {
  const auto& drive = scenario.drive;
  const double w = drive.angular_frequency, a = std::min(drive.amplitude, drive.amplitude_y) * w * w;
  const auto rate = [&](double mu) {
    const double m = mu * drive.gravity;
    const double u = std::sqrt(std::max(a * a - m * m, 0.16 * a * a)) / w;
    return 0.5 * m / u;
  };
  const double share = scenario.friction.pulse_width / (2 * pi);
  return 2 * pi / w *
         ((1 - share) * rate(scenario.friction.nominal) + share * rate(scenario.friction.reduced));
}

EndPoint whole_run(const Scenario& scenario, const model::IntegrationOptions& options) {
  const model::Trajectory trajectory = model::integrate(scenario, options);
  EndPoint end;
  end.cycles = static_cast<int>(scenario.end_time() * scenario.drive.angular_frequency / (2 * pi));
  if (options.derivatives.empty()) {
    end.position = trajectory.end().position;
  } else {
    const model::SensitiveSample sample = trajectory.sensitive_end();
    end.position = sample.sample.position;
    end.jacobian = sample.position_jacobian;
  }
  return end;
}

}  // namespace

EndPoint settled_end(const Scenario& scenario, const model::IntegrationOptions& options) {
  // Only with a fixed end time do derivatives by w grow evenly.
  const bool by_frequency = std::find(options.derivatives.begin(), options.derivatives.end(),
                                      model::Parameter::angular_frequency) != options.derivatives.end();
  const bool driven = scenario.drive.amplitude > 0 && scenario.drive.amplitude_y > 0;
  const double damping = driven ? damping_per_cycle(scenario) : 0;
  if ((by_frequency && !(scenario.duration > 0)) || !(damping > 0)) return whole_run(scenario, options);
  const double period = 2 * pi / scenario.drive.angular_frequency, end_time = scenario.end_time();
  const double needed = 2 + std::ceil(-1.15 * std::log(std::max(options.tolerance, 1e-16)) / damping);
  const double copies = std::floor(end_time / period + 1e-9) - needed;
  if (!(copies >= 2)) return whole_run(scenario, options);

  Scenario begin = scenario;
  begin.duration = end_time - copies * period;
  const model::Trajectory trajectory = model::integrate(begin, options);
  const double last = trajectory.end_time(), before = last - period;
  EndPoint end;
  end.cycles = static_cast<int>(needed);
  const auto settled = [&](const model::Sample& one, const model::Sample& other) {
    const Eigen::Vector2d drift = one.position - other.position;
    end.position = one.position + copies * drift;
    const double change = (one.velocity - other.velocity).norm();
    return 0.5 * period * change * copies * copies <= 10 * options.tolerance * end.position.norm();
  };
  if (options.derivatives.empty()) {
    if (!settled(trajectory.end(), trajectory.at(before))) return whole_run(scenario, options);
    return end;
  }
  const model::SensitiveSample one = trajectory.sensitive_at(last), other = trajectory.sensitive_at(before);
  if (!settled(one.sample, other.sample)) return whole_run(scenario, options);
  end.jacobian = (1 + copies) * one.position_jacobian - copies * other.position_jacobian;
  return end;
}

}  // namespace tribotrack::fit::internal
