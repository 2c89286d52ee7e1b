#include "apps/campaign/fit_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/campaign/compared_runs.h"
#include "apps/campaign/fit_stage.h"
#include "apps/files/scenario_file.h"
#include "apps/measuring/measure_track.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {

namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

const char* word_for(fit::Verdict verdict) {
  switch (verdict) {
    case fit::Verdict::identifiable:
      return "identifiable";
    case fit::Verdict::weak:
      return "weak";
    case fit::Verdict::not_identifiable:
      return "not identifiable";
  }
  return "";
}

/// Open ends (infinite) become null.
Json interval_json(const fit::Interval& interval, double unit) {
  return Json::array({finite_json(interval.low * unit), finite_json(interval.high * unit)});
}

Json parameters_json(const fit::FitResult& result, double mm_per_px) {
  Json json = Json::object();
  for (const fit::ParameterEstimate& p : result.parameters) {
    const double unit = campaign_unit_per_si(p.parameter, mm_per_px);
    json[fit::to_string(p.parameter)] = {{"estimate", finite_json(p.estimate * unit)},
                                         {"sd", finite_json(p.sd * unit)},
                                         {"ci95", interval_json(p.ci95, unit)},
                                         {"covariance_ci95", interval_json(p.covariance_ci95, unit)},
                                         {"profile_ci95", interval_json(p.profile_ci95, unit)}};
    if (p.ci95_pieces.size() > 1) {
      Json& pieces = json[fit::to_string(p.parameter)]["ci95_pieces"] = Json::array();
      for (const fit::Interval& piece : p.ci95_pieces) pieces.push_back(interval_json(piece, unit));
    }
    if (!p.profile.empty()) {
      Json& profile = json[fit::to_string(p.parameter)]["profile"] = {
          {"value", Json::array()}, {"chi2_rise", Json::array()}, {"level", p.profile_level}};
      for (const fit::ProfilePoint& point : p.profile) {
        profile["value"].push_back(finite_json(point.value * unit));
        profile["chi2_rise"].push_back(finite_json(point.rise));
      }
    }
    if (result.bootstrap > 0)
      json[fit::to_string(p.parameter)]["bootstrap_ci95"] = interval_json(p.bootstrap_ci95, unit);
  }
  return json;
}

Json minima_json(const fit::FitResult& result, double mm_per_px) {
  Json json = Json::array();
  for (const fit::OneMinimum& minimum : result.minima) {
    Json values = Json::object();
    for (const auto& [parameter, value] : minimum.values)
      values[fit::to_string(parameter)] = finite_json(value * campaign_unit_per_si(parameter, mm_per_px));
    json.push_back({{"parameters", values},
                    {"chi2_above_best", finite_json(minimum.chi2_above)},
                    {"sentence", minimum.sentence}});
  }
  return json;
}

/// Null where no driven track was fitted.
Json slow_json(const fit::CorrelatedErrors& slow) {
  if (!(slow.time > 0)) return {};
  return {{"time_s", slow.time},
          {"drift_mm", slow.drift * 1e3},
          {"walk_mm", slow.walk * 1e3},
          {"circle_mm", slow.circle * 1e3},
          {"overtones_mm", slow.overtones * 1e3},
          {"common_circle_mm", slow.common_circle * 1e3},
          {"common_overtones_mm", slow.common_overtones * 1e3}};
}

Json correlation_json(const fit::FitResult& result) {
  Json json = Json::object();
  for (std::size_t i = 0; i < result.parameters.size(); ++i)
    for (std::size_t j = 0; j < result.parameters.size(); ++j)
      json[fit::to_string(result.parameters[i].parameter)][fit::to_string(result.parameters[j].parameter)] =
          finite_json(result.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
  return json;
}

Json slide_json(const fit::RunResult& run) {
  Json json = {{"time_s", run.slide.time}, {"position_mm", Json::array()}, {"fitted_mm", Json::array()}};
  for (const double m : run.slide.measured) json["position_mm"].push_back(m * 1e3);
  for (const double m : run.slide.modelled) json["fitted_mm"].push_back(m * 1e3);
  json["sentence"] = slide_sentence(run);
  return json;
}

Json run_json(const Run& analysed, const fit::FitResult& result) {
  Json json = {{"name", analysed.given.name}, {"kind", analysed.given.free_slide ? "free_slide" : "pulses"}};
  if (!analysed.failure.empty()) {
    json["failure"] = analysed.failure;
    return json;
  }
  if (!analysed.given.free_slide) {
    const auto* gate =
        analysed.measurement && analysed.measurement->gate ? &*analysed.measurement->gate : nullptr;
    json["phi_rad"] = analysed.scenario.friction.phase;
    json["dtau_rad"] = analysed.scenario.friction.pulse_width;
    json["phi_from"] = gate ? gate->source : "commanded";
    if (gate) {
      json["phi_rad_sd"] = gate->phi.sd;
      json["dtau_rad_sd"] = gate->dtau.sd;
      json["commanded"] = {{"phi_rad", analysed.given.phi}, {"dtau_rad", analysed.given.dtau}};
    }
  }
  if (const CampaignRun& run = analysed.given; run.slope) {
    json["slope_rad"] = *run.slope;  // "scenario" is that of a level platform on which the part moves alike
    json["slope_rad_sd"] = optional_json(run.slope_sd);
  }
  if (!analysed.repeats.empty()) json["repeats"] = analysed.repeats;
  json["observables"] = Json::array();
  for (const fit::RunResult& run : result.runs) {
    if (run.name != analysed.given.name) continue;
    json["scenario"] = json_of(run.fitted);
    for (const fit::Residual& r : run.residuals)
      json["observables"].push_back({{"observable", r.observable},
                                     {"measured", finite_json(r.measured)},
                                     {"modelled", finite_json(r.modelled)},
                                     {"sd", finite_json(r.sd)},
                                     {"standardised", finite_json(r.standardised)}});
    for (std::size_t p = 0; p < run.influence.size(); ++p)
      json["influence"][fit::to_string(result.parameters[p].parameter)] = finite_json(run.influence[p]);
    if (run.points > 0) {
      json["points"] = run.points;
      json["residual_rms_mm"] = run.rms_m * 1e3;
    }
    if (!run.nuisance.empty()) json["nuisance"] = run.nuisance;
    if (!run.slide.time.empty()) json["slide"] = slide_json(run);
  }
  return json;
}

const char* word_for(fit::Loss loss) {
  switch (loss) {
    case fit::Loss::squares:
      return "squares";
    case fit::Loss::huber:
      return "huber";
    case fit::Loss::cauchy:
      return "cauchy";
  }
  return "";
}

Json next_json(const fit::NextExperiment& next, double mm_per_px) {
  Json json = {{"phi_rad", next.phi},
               {"dtau_rad", next.dtau},
               {"amplitude_mm", next.amplitude * 1e3},
               {"angular_frequency_rad_s", next.angular_frequency},
               {"aim", next.aim ? Json(fit::to_string(*next.aim)) : Json()},
               {"sentence", next.sentence}};
  for (const auto& [parameter, sd] : next.predicted_sd) {
    const double unit = campaign_unit_per_si(parameter, mm_per_px);
    json["predicted_sd"][fit::to_string(parameter)] = finite_json(sd * unit);
    json["predicted_ci95"][fit::to_string(parameter)] =
        interval_json(next.predicted_ci95.at(parameter), unit);
  }
  return json;
}

/// Of a source's quantity, to the unit that its name carries.
double quantity_unit(const std::string& quantity, double mm_per_px) {
  if (quantity == fit::to_string(fit::FitParameter::amplitude)) return 1e3;
  return quantity == fit::to_string(fit::FitParameter::scale) ? mm_per_px : 1;
}

/// What was looked at besides the parameters: outliers, models, systematics.
void add_checks(const fit::FitResult& result, double mm_per_px, Json& json) {
  json["p_value"] = finite_json(result.p_value);
  json["runs_test_p_value"] = finite_json(result.runs_test_p_value);
  json["outliers"] = Json::array();
  for (const fit::Outlier& outlier : result.outliers)
    json["outliers"].push_back(
        {{"run", outlier.run},
         {"deviation", finite_json(outlier.deviation)},
         {"chance", finite_json(outlier.chance)},
         {"looks_like_phi_rad", outlier.looks_like_phi ? Json(*outlier.looks_like_phi) : Json()},
         {"sentence", outlier.sentence}});
  json["models"] = Json::array();
  for (const fit::ModelComparison& model : result.models)
    json["models"].push_back({{"name", model.name},
                              {"unknowns", model.parameters},
                              {"chi2", finite_json(model.chi2)},
                              {"aic", finite_json(model.aic)},
                              {"bic", finite_json(model.bic)},
                              {"sentence", model.sentence}});
  json["left_out"] = result.left_out;
  json["systematics"] = result.systematics;
  json["budget"] = budget_json(result, mm_per_px);
  json["improve_first"] = result.improve_first;
  if (const Eigen::VectorXd sd = result.sd_from(fit::kFromCoder); (sd.array() > 0).any()) {
    for (std::size_t i = 0; i < result.parameters.size(); ++i) {
      const fit::FitParameter parameter = result.parameters[i].parameter;
      json["coding"]["sd"][fit::to_string(parameter)] =
          finite_json(sd(static_cast<Eigen::Index>(i)) * campaign_unit_per_si(parameter, mm_per_px));
    }
    json["coding"]["exceeds_interval"] = coder_exceeds_interval(result);
  }
  json["loss"] = word_for(result.loss);
  if (result.bootstrap > 0)
    json["bootstrap"] = {{"refits", result.bootstrap}, {"seed", result.bootstrap_seed}};
}

}  // namespace

Json budget_json(const fit::FitResult& result, double mm_per_px) {
  Json json = Json::array();
  for (const fit::BudgetEntry& entry : result.budget) {
    const double quantity = quantity_unit(entry.quantity, mm_per_px);
    Json row = {{"source", entry.source},
                {"quantity", entry.quantity.empty() ? Json() : Json(entry.quantity)},
                {"sd_of_source", entry.quantity.empty() ? Json() : finite_json(entry.sd * quantity)},
                {"from", entry.from},
                {"counted", entry.counted}};
    for (std::size_t i = 0; i < result.parameters.size(); ++i) {
      const fit::FitParameter parameter = result.parameters[i].parameter;
      const auto column = static_cast<Eigen::Index>(i);
      const double unit = campaign_unit_per_si(parameter, mm_per_px);
      row["contribution"][fit::to_string(parameter)] = finite_json(entry.contribution(column) * unit);
      if (entry.sensitivity.size() > 0)
        row["sensitivity"][fit::to_string(parameter)] =
            finite_json(entry.sensitivity(column) * unit / quantity);
    }
    json.push_back(row);
  }
  return json;
}

double campaign_unit_per_si(fit::FitParameter parameter, double mm_per_px) {
  return parameter == fit::FitParameter::scale ? mm_per_px : 1 / si_per_campaign_unit(parameter);
}

bool coder_exceeds_interval(const fit::FitResult& result) {
  constexpr double kHalfWidth = 1.96;  // of a 95 % interval, in sd
  const Eigen::VectorXd by_coder = result.sd_from(fit::kFromCoder);
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const double coder = by_coder(static_cast<Eigen::Index>(i)), all = result.parameters[i].sd;
    if (std::isfinite(all) && coder * coder > kHalfWidth * kHalfWidth * (all * all - coder * coder))
      return true;
  }
  return false;
}

std::string phase_reference(const Campaign& campaign, const std::vector<Run>& runs) {
  std::size_t by_camera = 0, by_sensor = 0;
  for (const Run& run : runs) {
    if (!run.failure.empty() || run.given.free_slide || !run.measurement) continue;
    if (run.measurement->phase_source == "assumed 0") continue;
    ++(run.measurement->gate_reference == "camera" ? by_camera : by_sensor);
  }
  if (by_camera + by_sensor == 0) return "";
  if (by_sensor == 0)
    return "phi was measured in the camera's own phase in every run: the lag does not depend on how the "
           "camera "
           "is turned.";
  return fmt::format(
      "phi counts from the phase sensor in {} of {} runs (commanded, or from an oscilloscope not tied to the "
      "camera): there an angle between the picture's x axis and the platform's displacement at the sensor's "
      "pulse, beyond xi_axis_rad = {:.4g}, stands in the lag, radian for radian. A lamp in the picture "
      "(gate_px) takes it out.",
      by_sensor, by_camera + by_sensor, campaign.camera.xi_axis_rad);
}

std::string slide_sentence(const fit::RunResult& run) {
  return fmt::format("Initial speed {:.4g} mm/s; {} points, residual {:.3g} mm rms.",
                     run.nuisance.at("initial_speed_mm_s"), run.points, run.rms_m * 1e3);
}

std::vector<std::string> warnings_of(const Campaign& campaign, const std::vector<Run>& runs,
                                     const fit::FitResult& result) {
  std::vector<std::string> warnings = repeated_text(runs);
  warnings.insert(warnings.end(), result.warnings.begin(), result.warnings.end());
  warnings.insert(warnings.end(), campaign.warnings.begin(), campaign.warnings.end());
  const auto estimated =
      std::ranges::count_if(runs, [](const Run& run) { return run.track && run.track->sd_from_scatter; });
  if (estimated > 0)
    warnings.push_back(fmt::format(
        "{} of {} runs are tracks without standard deviations: they are estimated from the scatter from "
        "point to point, and the intervals do not count errors slower than that",
        estimated, runs.size()));
  for (const Run& run : runs)
    if (run.measurement)
      warnings.insert(warnings.end(), run.measurement->warnings.begin(), run.measurement->warnings.end());
  return warnings;
}

Json fit_json(const Campaign& campaign, const std::vector<Run>& runs, const fit::FitResult& result) {
  Json json;
  json["parameters"] = parameters_json(result, reference_mm_per_px(runs));
  json["correlation"] = correlation_json(result);
  json["chi2"] = finite_json(result.chi2);
  json["dof"] = result.dof;
  json["agreement"] = fit::to_string(result.agreement);
  json["converged"] = result.converged;
  json["usable"] = result.usable();
  json["scatter_dominates"] = result.scatter_dominates;
  json["scatter_mm"] = result.scatter * 1e3;
  json["scatter_along_m"] = result.scatter_along;
  json["scatter_across_m"] = result.scatter_across;
  json["slow_errors"] = slow_json(result.correlated_errors);
  json["minima"] = minima_json(result, reference_mm_per_px(runs));
  json["covariance_meaning"] = result.covariance_meaning;
  json["identifiability"] = {{"verdict", word_for(result.identifiability.verdict)},
                             {"weak_directions", result.identifiability.weak_directions},
                             {"singular_values", result.identifiability.singular_values}};
  json["runs"] = Json::array();
  for (const Run& run : runs) json["runs"].push_back(run_json(run, result));
  json["slides"] = Json::array();
  for (const fit::SlideResult& slide : result.slides) json["slides"].push_back(slide_result_json(slide));
  if (result.slides.size() > 1)
    json["between_slides"] = {{"sd", result.between_slides},
                              {"p_value", finite_json(result.between_slides_p_value)}};
  const double mm_per_px = reference_mm_per_px(runs);
  json["next_experiment"] = result.next_experiment ? next_json(*result.next_experiment, mm_per_px) : Json();
  json["other_next_experiments"] = Json::array();
  for (const fit::NextExperiment& next : result.other_next_experiments)
    json["other_next_experiments"].push_back(next_json(next, mm_per_px));
  add_checks(result, mm_per_px, json);
  json["phase_reference"] = phase_reference(campaign, runs);
  json["warnings"] = warnings_of(campaign, runs, result);
  if (!campaign.notes.empty()) json["notes"] = campaign.notes;
  return json;
}

std::string parameter_table(const Json& fit) {
  std::string table =
      fmt::format("{:<26}{:>14}{:>12}{:>14}{:>14}\n", "parameter", "estimate", "sd", "ci95_low", "ci95_high");
  const auto number = [](const Json& value) { return value.is_number() ? value.get<double>() : kNoNumber; };
  for (const auto& [name, p] : fit.at("parameters").items()) {
    const double sd = number(p["sd"]), low = number(p["ci95"][0]), high = number(p["ci95"][1]);
    const auto end = [&](double value) { return rounded_end(value, low, high, sd); };
    table += fmt::format("{:<26}{:>14}{:>12}{:>14}{:>14}", name,
                         std::isfinite(sd) ? rounded_to_sd(number(p["estimate"]), sd) : "not determined",
                         std::isfinite(sd) ? rounded_to_sd(sd, sd) : "-", end(low), end(high));
    if (const auto pieces = p.find("ci95_pieces"); pieces != p.end()) {
      table += "  ";
      for (std::size_t i = 0; i < pieces->size(); ++i)
        table += fmt::format("{}{} to {}", i > 0 ? " or " : "", end(number((*pieces)[i][0])),
                             end(number((*pieces)[i][1])));
    }
    table += "\n";
  }
  return table;
}

std::string slide_table(const Json& fit) {
  if (fit.at("slides").empty()) return "";
  std::string table = fmt::format("{:<26}{:>14}{:>12}{:>14}{:>14}{:>12}{:>12}{:>8}\n", "slide", "mu1", "sd",
                                  "ci95_low", "ci95_high", "rim/speed", "chi2", "dof");
  const auto number = [](const Json& value) { return value.is_number() ? value.get<double>() : kNoNumber; };
  for (const Json& s : fit.at("slides")) {
    const double sd = number(s["mu1_sd"]), low = number(s["ci95"][0]), high = number(s["ci95"][1]);
    table += fmt::format("{:<26}{:>14}{:>12}{:>14}{:>14}{:>12}{:>12.4g}{:>8}\n", s["name"].get<std::string>(),
                         std::isfinite(sd) ? rounded_to_sd(number(s["mu1"]), sd) : "not determined",
                         std::isfinite(sd) ? rounded_to_sd(sd, sd) : "-", rounded_end(low, low, high, sd),
                         rounded_end(high, low, high, sd),
                         s.contains("slope_rad") ? "incline"
                         : s["spin_seen"].get<bool>()
                             ? rounded_to_sd(number(s["spin_ratio"]), number(s["spin_ratio_sd"]))
                             : "unseen",
                         number(s["chi2"]), s["dof"].get<int>());
  }
  return table;
}

std::vector<std::string> remedies(const fit::FitResult& result) {
  if (result.usable()) return {};
  std::vector<std::string> sentences = result.identifiability.weak_directions;
  if (result.next_experiment) sentences.push_back(result.next_experiment->sentence);
  for (const fit::NextExperiment& next : result.other_next_experiments)
    if (!result.next_experiment) sentences.push_back(next.sentence);
  return sentences;
}

}  // namespace tribotrack::apps
