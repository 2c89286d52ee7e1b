#include "fit/tools/parameters.h"

#include <algorithm>
#include <iterator>
#include <vector>

namespace tribotrack::fit::internal {

const ParameterFacts& facts(FitParameter parameter) {
  using enum Transform::Kind;
  using enum Sort;
  // In the order of the enumeration.
  static constexpr ParameterFacts kFacts[] = {
      {"mu1", nullptr, logarithm, not_negative},
      {"mu2", nullptr, hyperbola, not_negative},
      {"phase_lag_rad", nullptr, linear, phase},
      {"delay_s", nullptr, linear, number},
      {"amplitude_mm", "platform's amplitude", logarithm, positive},
      {"angular_frequency_rad_s", "platform's frequency", logarithm, positive},
      {"mm_per_px", "scale", logarithm, positive},
      {"tilt_x_rad", "tilt along x", linear, tilt},
      {"tilt_y_rad", "tilt along y", linear, tilt},
      {"amplitude_ratio", "ratio of the platform's amplitudes", logarithm, positive},
      {"phase_shift_rad", "platform's phase shift", linear, phase},
      {"phase_reference_rad", "phase reference", linear, phase},
      {"gravity_m_s2", "gravity", logarithm, positive},
      {"slope_rad", "incline's slope", linear, tilt},
      {"start_phase_rad", "phase at the start", linear, phase},
      {"mu2_width_1_rad", "rise of mu2 with the gate's width", linear, number},
      {"wear", "wear in the course of the campaign", linear, number},
      {"stribeck", "friction that falls with speed (Stribeck)", linear, number},
      {"stribeck_speed", "speed at which friction has fallen", logarithm, positive},
      {"viscous_1_s", "friction that rises with speed", linear, number},
      {"gate_edges_rad2", "width of the gate's edges", linear, number},
      {"mu2_speed", "rise of mu2 with speed", linear, number},
      {"static_friction", "friction at rest", linear, number}};
  static_assert(std::size(kFacts) == static_cast<std::size_t>(FitParameter::static_friction) + 1);
  return kFacts[static_cast<std::size_t>(parameter)];
}

double Reference::as_given(FitParameter parameter) const {
  switch (parameter) {
    case FitParameter::amplitude:
      return amplitude;
    case FitParameter::angular_frequency:
      return angular_frequency;
    case FitParameter::scale:
    case FitParameter::amplitude_ratio:
      return 1;
    case FitParameter::gravity:
      return gravity;
    case FitParameter::tilt_x:
      return tilt_x;
    case FitParameter::tilt_y:
      return tilt_y;
    case FitParameter::stribeck_speed:
      return kStribeckSpeed;
    default:
      return 0;
  }
}

Reference reference_of(const Problem& problem) {
  std::vector<model::Drive> drives;
  for (const auto& run : problem.summary_runs) drives.push_back(run.scenario.drive);
  for (const auto& run : problem.trajectory_runs) drives.push_back(run.scenario.drive);
  if (drives.empty()) return {};
  const auto driven = std::ranges::find_if(
      drives, [](const model::Drive& d) { return d.amplitude > 0 || d.amplitude_y > 0; });
  const model::Drive& drive = driven != drives.end() ? *driven : drives.front();
  return {std::max(drive.amplitude, drive.amplitude_y), drive.angular_frequency, drive.gravity, drive.tilt_x,
          drive.tilt_y};
}

}  // namespace tribotrack::fit::internal
