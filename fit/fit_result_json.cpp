#include "fit/fit_result_json.h"

#include <algorithm>
#include <cmath>

#include "fit/checks/runs.h"
#include "fit/checks/verdict.h"
#include "fit/report/json_fields.h"
#include "fit/tools/parameter_text.h"

namespace tribotrack::fit {
namespace internal {

void estimate(auto& io, const std::string& key, Estimate& estimate, bool there = true) {
  io(key.c_str(), estimate.value, there);
  io((key + "_sd").c_str(), estimate.sd, there);
}

/// A profile's points, column by column.
namespace {
struct ProfileColumns {
  std::vector<double> value, rise;
  double level = kNoNumber;
};
}  // namespace

void fields(auto& io, ProfileColumns& p) {
  io("value", p.value);
  io("chi2_rise", p.rise);
  io("level", p.level);
}

void fields(auto& io, ParameterEstimate& p) {
  io.need("estimate", p.estimate);
  io.sd("sd", p.sd);
  io.need("ci95", p.ci95);
  io("covariance_ci95", p.covariance_ci95);
  io("profile_ci95", p.profile_ci95);
  io("ci95_pieces", p.ci95_pieces, p.ci95_pieces.size() > 1);
  ProfileColumns profile{{}, {}, p.profile_level};
  for (const ProfilePoint& point : p.profile) {
    profile.value.push_back(point.value);
    profile.rise.push_back(point.rise);
  }
  io("profile", profile, !p.profile.empty());
  p.profile.clear();
  p.profile_level = profile.level;
  for (std::size_t k = 0; k < std::min(profile.value.size(), profile.rise.size()); ++k)
    p.profile.push_back({profile.value[k], profile.rise[k]});
  io("bootstrap_ci95", p.bootstrap_ci95, !std::isnan(p.bootstrap_ci95.low));
}

void fields(auto& io, CorrelatedErrors& e) {
  io("time_s", e.time);
  io.scaled("drift_mm", e.drift, 1e3);
  io.scaled("walk_mm", e.walk, 1e3);
  io.scaled("circle_mm", e.circle, 1e3);
  io.scaled("overtones_mm", e.overtones, 1e3);
  for (const char* common : {"common_circle_mm", "common_overtones_mm"}) io.derived(common, 0.0);
}

void fields(auto& io, OneMinimum& m) {
  io("parameters", m.values);
  io("chi2_above_best", m.chi2_above);
  io("sentence", m.sentence);
}

void fields(auto& io, Identifiability& i) {
  io.need("verdict", i.verdict);
  io("weak_directions", i.weak_directions);
  io("singular_values", i.singular_values);
}

void fields(auto& io, Residual& r) {
  io.need("observable", r.observable);
  io.need("measured", r.measured);
  io.need("modelled", r.modelled);
  io.need("sd", r.sd);
  io.need("standardised", r.standardised);
}

void fields(auto& io, model::Scenario& s) {
  io.scaled("amplitude_mm", s.drive.amplitude, 1e3);
  io.scaled("amplitude_y_mm", s.drive.amplitude_y, 1e3);
  io("omega_rad_s", s.drive.angular_frequency);
  io("epsilon_rad", s.drive.phase_shift);
  io("gravity_m_s2", s.drive.gravity);
  io("tilt_x_rad", s.drive.tilt_x);
  io("tilt_y_rad", s.drive.tilt_y);
  io("mu1", s.friction.nominal);
  io("mu2", s.friction.reduced);
  io("phi_rad", s.friction.phase);
  io("dtau_rad", s.friction.pulse_width);
  io("lag_rad", s.friction.lag);
  io.need("start", s.start);
  io("start_phase_rad", s.start_phase);
  io.scaled("velocity_x_mm_s", s.initial_velocity.x(), 1e3);
  io.scaled("velocity_y_mm_s", s.initial_velocity.y(), 1e3);
  io("cycles", s.cycles);
  const bool spins = s.spin.rate != 0;
  io("spin_rad_s", s.spin.rate, spins);
  io.scaled("radius_mm", s.spin.radius, 1e3, spins);
  io("spin_inertia", s.spin.inertia, spins);
  if (std::isnan(s.spin.rate)) s.spin = {};
  io("viscous_1_s", s.viscous, s.viscous != 0);
  if (std::isnan(s.viscous)) s.viscous = 0;
}

/// Refuses what nobody could compute.
void scenario(auto& io, model::Scenario& scenario) {
  io.need("scenario", scenario);
  io.check("scenario", [&](const JsonPlace& place) {
    constexpr double kMostCycles = 1e6;  // as in a campaign
    if (scenario.cycles > kMostCycles) place.at("cycles").refuse("1000000 or less");
    try {
      scenario.validate();
    } catch (const model::InvalidParameter&) {
      place.refuse("a scenario that can be computed");
    }
  });
}

void fields(auto& io, RunResult::Slide& slide) {
  io("time_s", slide.time);
  io.scaled("position_mm", slide.measured, 1e3);
  io.scaled("fitted_mm", slide.modelled, 1e3);
  io("sentence", slide.sentence);
}

void fields(auto& io, RunResult::Prediction& prediction) {
  io("chi2", prediction.chi2);
  io("p_value", prediction.p_value);
}

void fields(auto& io, RunResult& run) {
  io.need("name", run.name);
  io.need("observables", run.residuals);
  io("prediction", run.prediction, run.prediction.has_value());
  scenario(io, run.fitted);
  io.by_name("influence", run.influence, true);
  io("points", run.points, run.points > 0);
  io.scaled("residual_rms_mm", run.rms_m, 1e3, run.points > 0);
  io("nuisance", run.nuisance, !run.nuisance.empty());
  io("slide", run.slide, !run.slide.time.empty());
}

void fields(auto& io, Blow& blow) {
  io("frame", blow.frame);
  io("time_s", blow.time);
  io.scaled("jump_mm_s", blow.jump, 1e3);
  io.scaled("speed_before_mm_s", blow.speed_before, 1e3);
  io.scaled("speed_after_mm_s", blow.speed_after, 1e3);
}

void fields(auto& io, SlideResult& s) {
  io("name", s.run);
  estimate(io, "mu1", s.mu1);
  io("ci95", s.ci95);
  Estimate viscous = s.viscous.value_or(Estimate{kNoNumber, kNoNumber});
  estimate(io, "viscous_1_s", viscous, s.viscous.has_value());
  if (!std::isnan(viscous.value)) s.viscous = viscous;
  io("chi2", s.chi2);
  io("dof", s.dof);
  io("p_value", s.p_value);
  io.scaled("scatter_mm", s.scatter, 1e3);
  io("points", s.points);
  io("first_frame", s.first_frame);
  io("last_frame", s.last_frame);
  io.scaled("speed_mm_s", s.speed, 1e3);
  io("stop_time_s", s.stop_time);
  io("spin_seen", s.spin_seen);
  io("slope_rad", s.slope, s.slope != 0);
  if (std::isnan(s.slope)) s.slope = 0;
  estimate(io, "spin_rad_s", s.spin, s.spin_seen);
  estimate(io, "spin_ratio", s.spin_ratio, s.spin_seen);
  estimate(io, "bearing_over_radius", s.bearing, s.spin_seen);
  io("mu1_change_by_half_spin", s.change_by_half_spin, !s.spin_seen && s.slope == 0);
  io("blows", s.blows);
  io("sentence", s.sentence);
}

void fields(auto& io, NextExperiment& next) {
  io("phi_rad", next.phi);
  io("dtau_rad", next.dtau);
  io.scaled("amplitude_mm", next.amplitude, 1e3);
  io("angular_frequency_rad_s", next.angular_frequency);
  io("aim", next.aim);
  io("sentence", next.sentence);
  io("predicted_sd", next.predicted_sd, !next.predicted_sd.empty());
  io("predicted_ci95", next.predicted_ci95, !next.predicted_ci95.empty());
}

void fields(auto& io, Outlier& o) {
  io("run", o.run);
  io("deviation", o.deviation);
  io("chance", o.chance);
  io("looks_like_phi_rad", o.looks_like_phi);
  io("sentence", o.sentence);
}

void fields(auto& io, EstimateUnder& p) {
  io.need("estimate", p.estimate);
  io.sd("sd", p.sd);
  io.need("ci95", p.ci95);
}

void fields(auto& io, Explanation& e) {
  io.need("name", e.name);
  io("run", e.run, !e.run.empty());
  io("chi2_fall", e.chi2_fall);
  io("dof", e.dof);
  io("p_after", e.p_after);
  io("size", e.size);
  io("size_sd", e.size_sd);
  io("unit", e.unit);
  io("refitted", e.refitted);
  io("explains", e.explains);
  io("parameters", e.parameters);
}

void fields(auto& io, FrictionAtSpeed& at) {
  io.scaled("speed_mm_s", at.speed, 1e3);
  io("mu", at.mu);
  io("sd", at.sd);
}

/// The paper's law and the explanations by Akaike's and Schwarz's criteria.
inline Json models_json(const FitResult& fit) {
  Json models = Json::array();
  const auto n = static_cast<int>(fit.dof + static_cast<int>(fit.parameters.size()));
  const auto add = [&](const std::string& name, double chi2, int more) {
    const int unknowns = static_cast<int>(fit.parameters.size()) + more;
    models.push_back({{"name", name},
                      {"unknowns", unknowns},
                      {"chi2", finite_json(chi2)},
                      {"aic", finite_json(chi2 + 2 * unknowns)},
                      {"bic", finite_json(chi2 + unknowns * std::log(std::max(n, 1)))},
                      {"sentence", ""}});
  };
  for (const Explanation& e : fit.explanations) {
    if (models.empty()) add("Coulomb friction", fit.chi2, 0);
    add(e.name, fit.chi2 - e.chi2_fall, e.dof);
  }
  return models;
}

void fields(auto& io, BudgetEntry& entry) {
  std::optional<std::string> quantity;
  if (!entry.quantity.empty()) quantity = entry.quantity;
  if (!quantity) entry.sd = kNoNumber;
  io("source", entry.source);
  io("quantity", quantity);
  io("sd_of_source", entry.sd);
  io("from", entry.from);
  io("counted", entry.counted);
  io.by_name("contribution", entry.contribution);
  io.by_name("sensitivity", entry.sensitivity, true);
  entry.quantity = quantity.value_or("");
}

void fields(auto& io, FitResult::Refits& b) {
  io("refits", b.refits);
  io("seed", b.seed);
}

void fields(auto& io, FitResult::BetweenSlides& between) {
  io("sd", between.sd);
  io("p_value", between.p_value);
}

/// What a lossy coder does to each parameter; null where it does nothing.
inline Json coding_json(const FitResult& fit) {
  Json json;
  const Eigen::VectorXd sd = fit.sd_from(kFromCoder);
  if (!(sd.array() > 0).any()) return json;
  for (std::size_t k = 0; k < fit.parameters.size(); ++k)
    json["sd"][to_string(fit.parameters[k].parameter)] = finite_json(sd(static_cast<Eigen::Index>(k)));
  json["exceeds_interval"] = fit.coder_exceeds_interval();
  return json;
}

void fields(auto& io, FitResult& fit) {
  io.records("parameters", fit.parameters);
  io.by_name("correlation", fit.correlation);
  io.need("chi2", fit.chi2);
  io.need("dof", fit.dof);
  io.need("agreement", fit.agreement);
  io.need("converged", fit.converged);
  io("verdict", fit.verdict);
  io("verdict_reasons", fit.verdict_reasons);
  io("explanations", fit.explanations);
  io("quoted_under", fit.quoted_under);
  io("as_assumed", fit.as_assumed);
  io("mu_of_speed", fit.mu_of_speed);
  io.derived("usable", fit.usable());
  io("scatter_dominates", fit.scatter_dominates);
  io.scaled("scatter_mm", fit.scatter, 1e3);
  io("scatter_along_m", fit.scatter_between_runs);
  io("scatter_across_m", fit.scatter_between_runs);
  std::optional<CorrelatedErrors> slow;
  if (fit.correlated_errors.time > 0) slow = fit.correlated_errors;
  io("slow_errors", slow);
  fit.correlated_errors = slow.value_or(CorrelatedErrors{});
  io("minima", fit.minima);
  io("covariance_meaning", fit.covariance_meaning);
  io.need("identifiability", fit.identifiability);
  io.those_with("scenario", "runs", fit.runs);
  io("slides", fit.slides);
  io("between_slides", fit.between_slides, fit.slides.size() > 1);
  io("next_experiment", fit.next_experiment);
  io("other_next_experiments", fit.other_next_experiments);
  io("p_value", fit.p_value);
  io.derived("runs_test_p_value", runs_test(fit.runs));
  io("noise_dof", fit.noise_dof, std::isfinite(fit.noise_dof));
  if (std::isnan(fit.noise_dof)) fit.noise_dof = std::numeric_limits<double>::infinity();
  io("outliers", fit.outliers);
  io.derived("models", models_json(fit));
  io("left_out", fit.left_out);
  io("systematics", fit.systematics);
  io("budget", fit.budget);
  io("improve_first", fit.improve_first);
  if (const Json coding = coding_json(fit); !coding.is_null()) io.derived("coding", coding);
  io("loss", fit.loss);
  io("bootstrap", fit.bootstrap, fit.bootstrap.refits > 0);
  io("warnings", fit.warnings);
}

}  // namespace internal

namespace {

using internal::Order;

Json written(auto value, const Order& order) {
  Json json = Json::object();
  internal::Writer io(json, order);
  fields(io, value);
  return json;
}

Order order_of(const FitResult& fit) {
  Order order;
  for (const ParameterEstimate& p : fit.parameters) order.push_back(p.parameter);
  return order;
}

Interval times(const Interval& interval, double unit) {
  return {interval.low * unit, interval.high * unit};
}

NextExperiment in_key_units(NextExperiment next, double mm_per_px) {
  for (auto& [parameter, sd] : next.predicted_sd) sd *= key_unit_per_si(parameter, mm_per_px);
  for (auto& [parameter, ci95] : next.predicted_ci95)
    ci95 = times(ci95, key_unit_per_si(parameter, mm_per_px));
  return next;
}

/// Of a source's quantity.
double quantity_unit(const std::string& quantity, double mm_per_px) {
  for (const FitParameter parameter : {FitParameter::amplitude, FitParameter::scale})
    if (quantity == to_string(parameter)) return key_unit_per_si(parameter, mm_per_px);
  return 1;
}

}  // namespace

double key_unit_per_si(FitParameter parameter, double mm_per_px) {
  return parameter == FitParameter::scale ? mm_per_px : internal::display_factor(parameter);
}

FitResult in_key_units(FitResult fit, double mm_per_px) {
  Eigen::VectorXd units(static_cast<Eigen::Index>(fit.parameters.size()));
  for (std::size_t k = 0; k < fit.parameters.size(); ++k) {
    ParameterEstimate& p = fit.parameters[k];
    const double unit = units(static_cast<Eigen::Index>(k)) = key_unit_per_si(p.parameter, mm_per_px);
    p.estimate *= unit;
    p.sd *= unit;
    for (Interval* interval : {&p.ci95, &p.covariance_ci95, &p.profile_ci95, &p.bootstrap_ci95})
      *interval = times(*interval, unit);
    for (Interval& piece : p.ci95_pieces) piece = times(piece, unit);
    for (ProfilePoint& point : p.profile) point.value *= unit;
  }
  const auto convert = [&](std::map<FitParameter, EstimateUnder>& parameters) {
    for (auto& [parameter, p] : parameters) {
      const double unit = key_unit_per_si(parameter, mm_per_px);
      p = {p.estimate * unit, p.sd * unit, times(p.ci95, unit)};
    }
  };
  convert(fit.as_assumed);
  for (Explanation& explanation : fit.explanations) convert(explanation.parameters);
  if (fit.covariance.rows() == units.size())
    fit.covariance = units.asDiagonal() * fit.covariance * units.asDiagonal();
  for (OneMinimum& minimum : fit.minima)
    for (auto& [parameter, value] : minimum.values) value *= key_unit_per_si(parameter, mm_per_px);
  if (fit.next_experiment) fit.next_experiment = in_key_units(*fit.next_experiment, mm_per_px);
  for (NextExperiment& next : fit.other_next_experiments) next = in_key_units(next, mm_per_px);
  for (BudgetEntry& entry : fit.budget) {
    const double quantity = quantity_unit(entry.quantity, mm_per_px);
    entry.sd *= quantity;
    entry.contribution.array() *= units.array();
    if (entry.sensitivity.size() > 0)
      entry.sensitivity = entry.sensitivity.array() * units.array() / quantity;
  }
  return fit;
}

void to_json(Json& json, const FitResult& shown) {
  json = written(shown, order_of(shown));
}

void from_json(const Json& json, FitResult& shown) {
  Order order;
  internal::Reader io({json, ""}, order);
  fields(io, shown);
  if (!json.contains("verdict")) internal::judge(shown);
}

void to_json(Json& json, const SlideResult& slide) {
  json = written(slide, {});
}

}  // namespace tribotrack::fit
