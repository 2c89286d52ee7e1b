#include "apps/report/data/curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "fit/gate_timing.h"
#include "fit/measurement.h"
#include "fit/prediction.h"
#include "model/trajectory.h"

namespace tribotrack::apps {
namespace {

using fit::FitParameter;

constexpr std::size_t kFewGroups = 8;  // more curves than that are drawn with fewer points each

constexpr std::array kParameters = {
    FitParameter::mu1,   FitParameter::mu2,       FitParameter::lag,
    FitParameter::delay, FitParameter::amplitude, FitParameter::angular_frequency,
    FitParameter::scale, FitParameter::tilt_x,    FitParameter::tilt_y};

/// In SI; nullopt where a parameter is not known by that name, or not determined: then there is no band.
std::optional<fit::FittedParameters> known_parameters(const ReportData& data) {
  const auto n = static_cast<Eigen::Index>(data.parameters.size());
  if (data.correlation.size() != data.parameters.size()) return std::nullopt;
  fit::FittedParameters known{{}, Eigen::VectorXd(n), Eigen::MatrixXd(n, n)};
  Eigen::VectorXd sd(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ReportParameter& p = data.parameters[static_cast<std::size_t>(i)];
    const auto found = std::ranges::find_if(
        kParameters, [&](FitParameter parameter) { return p.name == fit::to_string(parameter); });
    if (found == kParameters.end() || !std::isfinite(p.sd)) return std::nullopt;
    const double unit = *found == FitParameter::amplitude ? 1e-3 : 1;
    known.parameters.push_back(*found);
    known.estimates(i) = unit * p.estimate;
    sd(i) = unit * p.sd;
  }
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const double r = data.correlation[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
      if (!std::isfinite(r)) return std::nullopt;
      known.covariance(i, j) = r * sd(i) * sd(j);
    }
  return known;
}

std::optional<fit::Displacement> followed(const model::Scenario& scenario,
                                          const std::optional<fit::FittedParameters>& known,
                                          long most_steps) {
  try {
    return fit::predicted_displacement(scenario, known.value_or(fit::FittedParameters{}), most_steps);
  } catch (const model::StepLimitExceeded&) {
    return std::nullopt;
  }
}

/// The scenario of a group's first run with one angle varied; how many points took more than `most_steps`.
std::size_t evaluate(model::Scenario scenario, bool over_phi,
                     const std::optional<fit::FittedParameters>& known, long most_steps, ReportGroup& group) {
  std::size_t left_out = 0;
  for (const double x : group.curve_x_rad) {
    (over_phi ? scenario.friction.phase : scenario.friction.pulse_width) = x;
    const std::optional<fit::Displacement> moved = followed(scenario, known, most_steps);
    left_out += !moved;
    const bool has_alpha = moved && moved->alpha;
    group.curve_alpha_rad.push_back(has_alpha ? moved->alpha->value : no_value);
    group.curve_alpha_sd_rad.push_back(known && has_alpha ? moved->alpha->sd : no_value);
    group.curve_v_mm_s.push_back(moved ? 1e3 * moved->mean_velocity.value : no_value);
    group.curve_v_sd_mm_s.push_back(known && moved ? 1e3 * moved->mean_velocity.sd : no_value);
  }
  return left_out;
}

}  // namespace

void add_curves(const std::vector<model::Scenario>& scenarios, ReportData& data, long most_steps) {
  const std::optional<fit::FittedParameters> known = known_parameters(data);
  data.over_phi = group_over_phi(data.runs);
  data.over_dtau = group_over_dtau(data.runs);
  const int points = data.over_phi.size() > kFewGroups || data.over_dtau.size() > kFewGroups ? 91 : 241;
  const auto all_points = static_cast<long>(data.over_phi.size() + data.over_dtau.size()) * points;
  const long share = most_steps / std::max(1L, all_points);
  std::size_t left_out = 0;
  for (ReportGroup& group : data.over_phi) {
    group.curve_x_rad = curve_phis(group, data.runs, points);
    left_out += evaluate(scenarios[group.runs.front()], true, known, share, group);
  }
  for (ReportGroup& group : data.over_dtau) {
    group.curve_x_rad = curve_dtaus(group, data.runs, points);
    left_out += evaluate(scenarios[group.runs.front()], false, known, share, group);
  }
  if (left_out > 0)
    data.warnings.push_back(fmt::format(
        "the model's curves lack {} of {} points, where the motion takes more than {} steps to follow",
        left_out, all_points, share));
}

namespace {

constexpr double full_turn = 2 * std::numbers::pi;

/// Values of the varied and of the shared angle, one per run.
struct Angles {
  std::vector<double> varied;
  std::vector<double> shared;
};

bool belongs_in_a_figure(const ReportRun& run) {
  return run.failure.empty() && run.kind != "free_slide" && std::isfinite(run.phi_rad) &&
         std::isfinite(run.dtau_rad) && std::isfinite(run.v_mm_s);
}

std::vector<double> phis(const std::vector<ReportRun>& runs, double tolerance) {
  std::vector<double> values;
  for (const ReportRun& run : runs) values.push_back(phi_in_one_turn(run.phi_rad, tolerance));
  return values;
}

std::vector<double> dtaus(const std::vector<ReportRun>& runs) {
  std::vector<double> values;
  for (const ReportRun& run : runs) values.push_back(run.dtau_rad);
  return values;
}

void sort_by(const std::vector<double>& angle, std::vector<std::size_t>& members) {
  std::stable_sort(members.begin(), members.end(),
                   [&](std::size_t a, std::size_t b) { return angle[a] < angle[b]; });
}

std::vector<ReportGroup> group(const Angles& angles, const std::vector<ReportRun>& runs, double tolerance) {
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (belongs_in_a_figure(runs[i])) members.push_back(i);
  sort_by(angles.shared, members);

  std::vector<ReportGroup> groups;
  for (const std::size_t i : members) {
    if (groups.empty() || angles.shared[i] - angles.shared[groups.back().runs.back()] > tolerance) {
      groups.emplace_back();
      groups.back().shared_rad = angles.shared[i];
    }
    groups.back().runs.push_back(i);
  }
  for (ReportGroup& g : groups) sort_by(angles.varied, g.runs);
  std::erase_if(groups, [&](const ReportGroup& g) {
    return angles.varied[g.runs.back()] - angles.varied[g.runs.front()] <= tolerance;
  });
  return groups;
}

std::vector<double> even_steps(double from, double to, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(from + (to - from) * i / std::max(count - 1, 1));
  return values;
}

std::vector<double> padded_range(double first, double last, int count) {
  const double spare = 0.1 * (last - first);
  return even_steps(std::max(0.0, first - spare), std::min(full_turn, last + spare), count);
}

}  // namespace

double phi_in_one_turn(double phi_rad, double tolerance) {
  const double wrapped = phi_rad - full_turn * std::floor(phi_rad / full_turn);
  return wrapped > full_turn - tolerance ? wrapped - full_turn : wrapped;
}

std::vector<ReportGroup> group_over_phi(const std::vector<ReportRun>& runs, double tolerance) {
  return group({.varied = phis(runs, tolerance), .shared = dtaus(runs)}, runs, tolerance);
}

std::vector<ReportGroup> group_over_dtau(const std::vector<ReportRun>& runs, double tolerance) {
  return group({.varied = dtaus(runs), .shared = phis(runs, tolerance)}, runs, tolerance);
}

std::vector<double> curve_phis(const ReportGroup& group, const std::vector<ReportRun>& runs, int count) {
  if (group.runs.empty()) return {};
  const double first = phi_in_one_turn(runs[group.runs.front()].phi_rad);
  const double last = phi_in_one_turn(runs[group.runs.back()].phi_rad);
  if (last - first >= std::numbers::pi) return even_steps(0, full_turn, count);
  return padded_range(first, last, count);
}

std::vector<double> curve_dtaus(const ReportGroup& group, const std::vector<ReportRun>& runs, int count) {
  if (group.runs.empty()) return {};
  return padded_range(runs[group.runs.front()].dtau_rad, runs[group.runs.back()].dtau_rad, count);
}

namespace {

std::size_t first_measured(const ReportRun& run) {
  std::size_t first = 0;
  while (first < run.x_mm.size() && !(std::isfinite(run.x_mm[first]) && std::isfinite(run.y_mm[first])))
    ++first;
  return first;
}

/// Straight between the two frames about each whole cycle; none where one of them is lost.
void mark_cycles(double start, double period, ReportRun& run) {
  std::size_t right = 1;
  for (int cycle = 0;; ++cycle) {
    const double time = start + cycle * period;
    while (right < run.time_s.size() && run.time_s[right] < time) ++right;
    if (right >= run.time_s.size()) return;
    const double share = (time - run.time_s[right - 1]) / (run.time_s[right] - run.time_s[right - 1]);
    const auto between = [&](const std::vector<double>& v) {
      return v[right - 1] + share * (v[right] - v[right - 1]);
    };
    if (!std::isfinite(between(run.x_mm)) || !std::isfinite(between(run.y_mm))) continue;
    run.cycle_x_mm.push_back(between(run.x_mm));
    run.cycle_y_mm.push_back(between(run.y_mm));
  }
}

std::optional<model::Trajectory> followed(const model::Scenario& scenario, long most_steps) {
  model::IntegrationOptions options;
  options.max_steps = most_steps;
  try {
    return model::integrate(scenario, options);
  } catch (const model::StepLimitExceeded&) {
    return std::nullopt;
  }
}

}  // namespace

bool add_model_path(const model::Scenario& scenario, bool in_camera_frame, ReportRun& run, long most_steps) {
  const double w = scenario.drive.angular_frequency;
  if (in_camera_frame || run.kind == "free_slide" || run.time_s.size() < 2 ||
      run.x_mm.size() != run.time_s.size() || !(w > 0))
    return true;
  const std::size_t first = first_measured(run);
  if (first == run.x_mm.size()) return true;
  const double start = run.time_s[first];
  mark_cycles(start, 2 * std::numbers::pi / w, run);
  const std::optional<model::Trajectory> path = followed(scenario, most_steps);
  if (!path) return false;
  for (std::size_t i = 0; i < run.time_s.size(); ++i) {
    const double time = run.time_s[i] - start;
    const bool modelled = time >= 0 && time <= path->end_time();
    const Eigen::Vector2d at =
        modelled ? Eigen::Vector2d(1e3 * path->at(time).position) : Eigen::Vector2d::Constant(no_value);
    run.model_x_mm.push_back(run.x_mm[first] + at.x());
    run.model_y_mm.push_back(run.y_mm[first] + at.y());
  }
  return true;
}

void note_no_model_path(const ReportRun& run, ReportData& data) {
  data.warnings.push_back(fmt::format(
      "run {}: the model's path is left out: the motion takes too many steps to follow", run.name));
}

namespace {

void add_orbit(const Track& track, const fit::PlatformMotion& motion, ReportPlatform& platform) {
  const fit::PlatformPicture picture = fit::picture_of(track.table, motion);
  for (std::size_t k = 0; k < picture.orbit.size(); ++k) {
    platform.orbit_x_mm.push_back(picture.orbit[k].x() * 1e3);
    platform.orbit_y_mm.push_back(picture.orbit[k].y() * 1e3);
    platform.time_s.push_back(track.table.time[k]);
    platform.phase_left_mrad.push_back(picture.phase_left[k] * 1e3);
  }
  for (const Eigen::Vector2d& m : picture.model) {
    platform.model_x_mm.push_back(m.x() * 1e3);
    platform.model_y_mm.push_back(m.y() * 1e3);
  }
}

void add_lamp(const fit::LampRecord& lamp, const fit::PlatformMotion& motion, ReportPlatform& platform) {
  const fit::PhaseClock clock{motion.angular_frequency.value, motion.phase_at_zero.value, 0};
  fit::GateTiming gate;
  gate.phi.value = platform.phi_rad;
  gate.dtau.value = platform.dtau_rad;
  gate.off_level = platform.lamp_off_level;
  gate.on_level = platform.lamp_on_level;
  const fit::FoldedLamp folded = fit::fold_lamp(lamp, clock, gate);
  platform.gate_phase_rad = folded.phase;
  platform.gate_share = folded.share;
  const fit::FoldedLamp model = fit::modelled_lamp(lamp, clock, gate);
  platform.gate_model_phase_rad = model.phase;
  platform.gate_model_share = model.share;
}

}  // namespace

void add_drawings(const Track& track, ReportPlatform& platform) {
  if (!std::isfinite(platform.amplitude_mm) || track.table.marker.empty()) return;
  fit::PlatformMotion motion;
  motion.amplitude.value = platform.amplitude_mm * 1e-3;
  motion.amplitude_y.value = platform.amplitude_y_mm * 1e-3;
  motion.angular_frequency.value = platform.w_rad_s;
  motion.phase_shift.value = platform.epsilon_rad;
  motion.phase_at_zero.value = platform.phase_at_zero_rad;
  add_orbit(track, motion, platform);
  const bool lamp_gave_phi = std::isfinite(platform.lamp_on_level) && std::isfinite(platform.phi_rad);
  if (lamp_gave_phi && !track.lamp.time.empty()) add_lamp(track.lamp, motion, platform);
}

}  // namespace tribotrack::apps
