#include "apps/report/data/curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "fit/measurement.h"
#include "fit/prediction.h"
#include "model/trajectory.h"

namespace tribotrack::apps {
namespace {

constexpr std::size_t kFewGroups = 8;  // more curves than that are drawn with fewer points each

/// In SI; nullopt where a parameter is not determined: then there is no band.
std::optional<fit::FittedParameters> known_parameters(const fit::FitResult& fit) {
  const auto n = static_cast<Eigen::Index>(fit.parameters.size());
  if (fit.correlation.rows() != n || fit.correlation.cols() != n || !fit.correlation.allFinite())
    return std::nullopt;
  fit::FittedParameters known{{}, Eigen::VectorXd(n), Eigen::MatrixXd(n, n)};
  Eigen::VectorXd sd(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const fit::ParameterEstimate& p = fit.parameters[static_cast<std::size_t>(i)];
    if (!std::isfinite(p.sd)) return std::nullopt;
    const double unit = p.parameter == fit::FitParameter::amplitude ? 1e-3 : 1;
    known.parameters.push_back(p.parameter);
    known.estimates(i) = unit * p.estimate;
    sd(i) = unit * p.sd;
  }
  known.covariance = sd.asDiagonal() * fit.correlation * sd.asDiagonal();
  return known;
}

/// What `solve` gives; nothing where the motion takes more steps than it may.
template <class Solve>
auto followed(const Solve& solve) -> std::optional<decltype(solve())> {
  try {
    return solve();
  } catch (const model::StepLimitExceeded&) {
    return std::nullopt;
  }
}

/// The scenario of a group's first run with one angle varied; how many points took more than `most_steps`.
std::size_t evaluate(model::Scenario scenario, Over over, const std::optional<fit::FittedParameters>& known,
                     long most_steps, ReportGroup& group) {
  std::size_t left_out = 0;
  for (const double x : group.curve_x_rad) {
    (over == Over::phi ? scenario.friction.phase : scenario.friction.pulse_width) = x;
    const auto moved = followed([&] {
      return fit::predicted_displacement(scenario, known.value_or(fit::FittedParameters{}), most_steps);
    });
    left_out += !moved;
    const bool has_alpha = moved && moved->alpha;
    group.curve_alpha_rad.push_back(has_alpha ? moved->alpha->value : no_value);
    group.curve_alpha_sd_rad.push_back(known && has_alpha ? moved->alpha->sd : no_value);
    group.curve_v_mm_s.push_back(moved ? 1e3 * moved->mean_velocity.value : no_value);
    group.curve_v_sd_mm_s.push_back(known && moved ? 1e3 * moved->mean_velocity.sd : no_value);
  }
  return left_out;
}

constexpr double full_turn = 2 * std::numbers::pi;
constexpr double kSameAngle = 0.02;  // rad: measured angles scatter

bool belongs_in_a_figure(const ReportRun& run) {
  return run.failure.empty() && !run.free_slide && std::isfinite(run.phi_rad) &&
         std::isfinite(run.dtau_rad) && std::isfinite(run.value("v_mm_s").value);
}

}  // namespace

void add_curves(ReportData& data, long most_steps) {
  const std::optional<fit::FittedParameters> known = known_parameters(data.fit);
  data.over_phi = groups_over(Over::phi, data.runs);
  data.over_dtau = groups_over(Over::dtau, data.runs);
  const int points = data.over_phi.size() > kFewGroups || data.over_dtau.size() > kFewGroups ? 91 : 241;
  const auto all_points = static_cast<long>(data.over_phi.size() + data.over_dtau.size()) * points;
  const long share = most_steps / std::max(1L, all_points);
  std::size_t left_out = 0;
  for (const Over over : {Over::phi, Over::dtau})
    for (ReportGroup& group : over == Over::phi ? data.over_phi : data.over_dtau) {
      group.curve_x_rad = curve_angles(over, group, data.runs, points);
      left_out += evaluate(data.runs[group.runs.front()].fitted.fitted, over, known, share, group);
    }
  if (left_out > 0)
    data.warnings.push_back(fmt::format(
        "the model's curves lack {} of {} points, where the motion takes more than {} steps to follow",
        left_out, all_points, share));
}

double angle_over(Over over, const ReportRun& run) {
  if (over == Over::dtau) return run.dtau_rad;
  const double wrapped = run.phi_rad - full_turn * std::floor(run.phi_rad / full_turn);
  return wrapped > full_turn - kSameAngle ? wrapped - full_turn : wrapped;
}

std::vector<ReportGroup> groups_over(Over over, const std::vector<ReportRun>& runs) {
  const auto varied = [&](std::size_t i) { return angle_over(over, runs[i]); };
  const auto shared = [&](std::size_t i) {
    return angle_over(over == Over::phi ? Over::dtau : Over::phi, runs[i]);
  };
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (belongs_in_a_figure(runs[i])) members.push_back(i);
  std::ranges::stable_sort(members, {}, shared);
  std::vector<ReportGroup> groups;
  for (const std::size_t i : members) {
    if (groups.empty() || shared(i) - shared(groups.back().runs.back()) > kSameAngle) {
      groups.emplace_back();
      groups.back().shared_rad = shared(i);
    }
    groups.back().runs.push_back(i);
  }
  for (ReportGroup& group : groups) std::ranges::stable_sort(group.runs, {}, varied);
  std::erase_if(groups, [&](const ReportGroup& group) {
    return varied(group.runs.back()) - varied(group.runs.front()) <= kSameAngle;
  });
  return groups;
}

std::vector<double> curve_angles(Over over, const ReportGroup& group, const std::vector<ReportRun>& runs,
                                 int count) {
  double from = angle_over(over, runs[group.runs.front()]), to = angle_over(over, runs[group.runs.back()]);
  const bool whole = over == Over::phi && to - from >= std::numbers::pi;
  const double spare = 0.1 * (to - from);
  from = whole ? 0 : std::max(0.0, from - spare);
  to = whole ? full_turn : std::min(full_turn, to + spare);
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(from + (to - from) * i / std::max(count - 1, 1));
  return values;
}

namespace {

std::size_t first_measured(const Track& track) {
  std::size_t first = 0;
  while (first < track.x_mm.size() && !(std::isfinite(track.x_mm[first]) && std::isfinite(track.y_mm[first])))
    ++first;
  return first;
}

/// Straight between the two frames about each whole cycle; none where one of them is lost.
void mark_cycles(double start, double period, ReportRun& run) {
  const Track& track = run.track;
  std::size_t right = 1;
  for (int cycle = 0;; ++cycle) {
    const double time = start + cycle * period;
    while (right < track.time_s.size() && track.time_s[right] < time) ++right;
    if (right >= track.time_s.size()) return;
    const double share = (time - track.time_s[right - 1]) / (track.time_s[right] - track.time_s[right - 1]);
    const auto between = [&](const std::vector<double>& v) {
      return v[right - 1] + share * (v[right] - v[right - 1]);
    };
    if (!std::isfinite(between(track.x_mm)) || !std::isfinite(between(track.y_mm))) continue;
    run.cycle_x_mm.push_back(between(track.x_mm));
    run.cycle_y_mm.push_back(between(track.y_mm));
  }
}

}  // namespace

bool add_model_path(ReportRun& run, long most_steps) {
  const model::Scenario& scenario = run.fitted.fitted;
  const Track& track = run.track;
  const double w = scenario.drive.angular_frequency;
  if (track.in_camera_frame || run.free_slide || track.time_s.size() < 2 ||
      track.x_mm.size() != track.time_s.size() || !(w > 0))
    return true;
  const std::size_t first = first_measured(track);
  if (first == track.x_mm.size()) return true;
  const double start = track.time_s[first];
  mark_cycles(start, 2 * std::numbers::pi / w, run);
  model::IntegrationOptions options;
  options.max_steps = most_steps;
  const auto path = followed([&] { return model::integrate(scenario, options); });
  if (!path) return false;
  for (const double frame_time : track.time_s) {
    const double time = frame_time - start;
    const bool modelled = time >= 0 && time <= path->end_time();
    const Eigen::Vector2d at =
        modelled ? Eigen::Vector2d(1e3 * path->at(time).position) : Eigen::Vector2d::Constant(no_value);
    run.model_x_mm.push_back(track.x_mm[first] + at.x());
    run.model_y_mm.push_back(track.y_mm[first] + at.y());
  }
  return true;
}

void add_drawings(ReportRun& run) {
  const auto value = [&](const char* key) { return run.value(key).value; };
  if (std::isnan(value("amplitude_mm")) || run.track.table.marker.empty()) return;
  fit::PlatformMotion motion;
  motion.amplitude.value = value("amplitude_mm") * 1e-3;
  motion.amplitude_y.value = value("amplitude_y_mm") * 1e-3;
  motion.angular_frequency.value = value("angular_frequency_rad_s");
  motion.phase_shift.value = value("phase_shift_rad");
  motion.phase_at_zero.value = value("phase_at_zero_rad");
  run.platform = fit::picture_of(run.track.table, motion);
}

}  // namespace tribotrack::apps
