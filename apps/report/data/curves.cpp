#include "apps/report/data/curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "apps/report/data/groups.h"
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

}  // namespace tribotrack::apps
