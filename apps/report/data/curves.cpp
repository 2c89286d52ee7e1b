#include "apps/report/data/curves.h"

#include "apps/report/data/groups.h"
#include "fit/problem.h"
#include "model/alpha_v.h"

namespace tribotrack::apps {
namespace {

void evaluate(const model::Scenario& first, bool over_phi, ReportGroup& group) {
  model::Scenario scenario = first;
  for (const double x : group.curve_x_rad) {
    (over_phi ? scenario.friction.phase : scenario.friction.pulse_width) = x;
    const Eigen::Vector2d displacement = fit::modelled_displacement(scenario);
    const bool moved = displacement.norm() > 0;
    group.curve_alpha_rad.push_back(moved ? model::displacement_angle(displacement) : no_value);
    group.curve_v_mm_s.push_back(model::mean_velocity(displacement, scenario.end_time()) * 1e3);
  }
}

}  // namespace

void add_curves(const std::vector<model::Scenario>& scenarios, ReportData& data) {
  data.over_phi = group_over_phi(data.runs);
  for (ReportGroup& group : data.over_phi) {
    group.curve_x_rad = curve_phis(group, data.runs);
    evaluate(scenarios[group.runs.front()], true, group);
  }
  data.over_dtau = group_over_dtau(data.runs);
  for (ReportGroup& group : data.over_dtau) {
    group.curve_x_rad = curve_dtaus(group, data.runs);
    evaluate(scenarios[group.runs.front()], false, group);
  }
}

}  // namespace tribotrack::apps
