#include "apps/report/data/model_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "model/trajectory.h"

namespace tribotrack::apps {
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

}  // namespace tribotrack::apps
