#include "apps/campaign/fit_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/campaign/compared_runs.h"
#include "apps/campaign/fit_stage.h"
#include "apps/text/number_text.h"
#include "fit/fit_result_json.h"

namespace tribotrack::apps {

namespace {

/// What was given and measured of a run, before what the fit says of it.
Json run_json(const Run& analysed) {
  const CampaignRun& run = analysed.given;
  Json json = {{"name", run.name}, {"kind", run.free_slide ? "free_slide" : "pulses"}};
  if (!analysed.failure.empty()) {
    json["failure"] = analysed.failure;
    return json;
  }
  if (!run.free_slide) {
    const auto& gate = analysed.gate;
    json["phi_rad"] = analysed.scenario.friction.phase;
    json["dtau_rad"] = analysed.scenario.friction.pulse_width;
    json["phi_from"] = gate && analysed.gate_reference != "command" ? gate->source : "commanded";
    if (gate) {
      json["phi_rad_sd"] = gate->phi.sd;
      json["dtau_rad_sd"] = gate->dtau.sd;
      json["commanded"] = {{"phi_rad", run.phi}, {"dtau_rad", run.dtau}};
    }
  }
  if (run.slope) {
    json["slope_rad"] = *run.slope;  // "scenario" is that of a level platform on which the part moves alike
    json["slope_rad_sd"] = optional_json(run.slope_sd);
  }
  if (!analysed.repeats.empty()) json["repeats"] = analysed.repeats;
  json["observables"] = Json::array();
  return json;
}

/// What phi counts from, and with it the effect of a turned camera on the lag. Empty without pulses.
std::string phase_reference(const Campaign& campaign, const std::vector<Run>& runs) {
  std::size_t by_camera = 0, by_sensor = 0;
  for (const Run& run : runs) {
    if (!run.failure.empty() || run.given.free_slide || !run.measurement) continue;
    if (run.measurement->phase_source == "assumed 0") continue;
    ++(run.gate_reference == "camera" ? by_camera : by_sensor);
  }
  if (by_camera + by_sensor == 0) return "";
  if (by_sensor == 0)
    return "phi was measured in the camera's own phase in every run: the lag does not depend on how the "
           "camera "
           "is turned.";
  return fmt::format(
      "phi counts from the phase sensor in {} of {} runs (commanded, or from an oscilloscope not tied to the "
      "camera): there an angle between the picture's x axis and the platform's displacement at the sensor's "
      "pulse, beyond xi_axis_rad = {:.4g}, biases the phase lag one to one. A gate LED in the picture "
      "(gate_px) removes it.",
      by_sensor, by_camera + by_sensor, campaign.camera.xi_axis_rad);
}

/// From the fit, the campaign file and each run's measurement.
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

}  // namespace

Json fit_json(const Campaign& campaign, const std::vector<Run>& runs, const fit::FitResult& result) {
  Json json = fit::in_key_units(result, reference_mm_per_px(runs));
  const Json fitted = std::exchange(json["runs"], Json::array());
  for (const Run& run : runs) {
    Json entry = run_json(run);
    for (const Json& one : fitted)
      if (one["name"] == entry["name"] && run.failure.empty()) entry.update(one);
    json["runs"].push_back(entry);
  }
  json["warnings"] = warnings_of(campaign, runs, result);
  json["phase_reference"] = phase_reference(campaign, runs);
  if (!campaign.notes.empty()) json["notes"] = campaign.notes;
  return json;
}

namespace {

/// "not determined", "-" without a finite sd.
std::string estimate_and_sd(double estimate, double sd) {
  return fmt::format("{:>14}{:>12}", std::isfinite(sd) ? rounded_to_sd(estimate, sd) : "not determined",
                     std::isfinite(sd) ? rounded_to_sd(sd, sd) : "-");
}

}  // namespace

std::string parameter_table(const Json& fit) {
  std::string table =
      fmt::format("{:<26}{:>14}{:>12}{:>14}{:>14}\n", "parameter", "estimate", "sd", "ci95_low", "ci95_high");
  const auto result = fit.get<fit::FitResult>();
  for (const fit::ParameterEstimate& p : result.parameters) {
    const auto end = [&](double value) { return rounded_end(value, p.ci95.low, p.ci95.high, p.sd); };
    table += fmt::format("{:<26}{}{:>14}{:>14}", fit::to_string(p.parameter),
                         estimate_and_sd(p.estimate, p.sd), end(p.ci95.low), end(p.ci95.high));
    for (std::size_t i = 0; i < p.ci95_pieces.size(); ++i)
      table += fmt::format("{}{} to {}", i > 0 ? " or " : "  ", end(p.ci95_pieces[i].low),
                           end(p.ci95_pieces[i].high));
    table += "\n";
  }
  if (!result.as_assumed.empty()) table += "as described: " + as_described(result) + "\n";
  return table + result.verdict_text() + "\n";
}

std::string slide_table(const Json& fit) {
  const std::vector<fit::SlideResult> slides = fit.get<fit::FitResult>().slides;
  if (slides.empty()) return "";
  std::string table = fmt::format("{:<26}{:>14}{:>12}{:>14}{:>14}{:>12}{:>12}{:>8}\n", "slide", "mu1", "sd",
                                  "ci95_low", "ci95_high", "edge/speed", "chi2", "dof");
  for (const fit::SlideResult& s : slides)
    table += fmt::format("{:<26}{}{:>14}{:>14}{:>12}{:>12.4g}{:>8}\n", s.run,
                         estimate_and_sd(s.mu1.value, s.mu1.sd),
                         rounded_end(s.ci95.low, s.ci95.low, s.ci95.high, s.mu1.sd),
                         rounded_end(s.ci95.high, s.ci95.low, s.ci95.high, s.mu1.sd),
                         s.slope != 0  ? "incline"
                         : s.spin_seen ? rounded_to_sd(s.spin_ratio.value, s.spin_ratio.sd)
                                       : "unseen",
                         s.chi2, s.dof);
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
