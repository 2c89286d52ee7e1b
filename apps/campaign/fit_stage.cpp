#include "apps/campaign/fit_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <string>
#include <utility>

#include "apps/campaign/compared_runs.h"
#include "apps/campaign/slips.h"
#include "apps/files/run_folder.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/number_text.h"
#include "fit/fit_result_json.h"
#include "fit/rounding.h"

namespace tribotrack::apps {

namespace {

/// mm/px that the fit parameter `scale` is a factor on: the mean over the runs with a video; 1 where there is
/// none.
double reference_mm_per_px(const std::vector<Run>& runs) {
  double sum = 0;
  int count = 0;
  for (const Run& run : runs)
    if (run.takes_part() && run.track && run.track->mm_per_px) {
      sum += *run.track->mm_per_px;
      ++count;
    }
  return count > 0 ? sum / count : 1;
}

void add_run(const Campaign& campaign, const Run& run, fit::Problem& problem) {
  const std::string& name = run.given.name;
  const bool held_out = std::ranges::count(campaign.fit.hold_out, name) > 0;
  if (run.given.free_slide) {
    fit::TrajectoryRun slide{name, run.scenario, run.track->table, true, false};
    slide.slope = run.given.slope.value_or(0);
    problem.trajectory_runs.push_back(std::move(slide));
  } else if (campaign.fit.trajectory && run.track && !held_out) {
    fit::TrajectoryRun trajectory{name, run.scenario, run.track->table, false, run.amplitude_from_track};
    trajectory.start_phase_sd = run.own.sd(model::Parameter::start_phase);
    trajectory.own = run.own.without(model::Parameter::start_phase);
    problem.trajectory_runs.push_back(std::move(trajectory));
  } else {
    problem.summary_runs.push_back({name, run.scenario, run.displacement, run.amplitude_from_track, run.own});
    problem.summary_runs.back().held_out = held_out;
  }
}

}  // namespace

fit::Problem problem_of(const Campaign& campaign, const std::vector<Run>& runs,
                        const SharedConditions& shared) {
  fit::Problem problem;
  problem.free = campaign.fit.parameters;
  const double mm_per_px = reference_mm_per_px(runs);
  const auto si = [&](fit::FitParameter parameter, double value) {
    return parameter == fit::FitParameter::scale ? value / mm_per_px
                                                 : value * si_per_campaign_unit(parameter);
  };
  for (const auto& [parameter, value] : campaign.fit.fixed) problem.fixed[parameter] = si(parameter, value);
  for (const auto& [parameter, value] : campaign.fit.guess) problem.start[parameter] = si(parameter, value);
  for (const auto& [parameter, prior] : campaign.fit.prior)
    problem.prior[parameter] = {si(parameter, prior.mean), si(parameter, prior.sd)};

  for (const Run& run : runs)
    if (run.takes_part()) add_run(campaign, run, problem);
  fit::put_into(problem, shared.pooled);
  return problem;
}

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
           "camera is turned.";
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
    warnings.push_back(
        fmt::format("{} of {} runs are tracks without standard deviations: they are estimated from the "
                    "scatter from point to point, and the intervals do not count errors slower than that",
                    estimated, runs.size()));
  for (const Run& run : runs)
    if (run.measurement)
      warnings.insert(warnings.end(), run.measurement->warnings.begin(), run.measurement->warnings.end());
  return warnings;
}

/// The object of fit.json. Parameters stand in campaign units, as their names say.
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

/// What a lossy coder does to the parameters.
std::string coding_sentence(const fit::FitResult& result) {
  std::string list;
  const Eigen::VectorXd sd = result.sd_from(fit::kFromCoder);
  for (std::size_t i = 0; i < result.parameters.size(); ++i)
    list += fmt::format("{}{} +- {:.2g}", i > 0 ? ", " : "", fit::to_string(result.parameters[i].parameter),
                        sd(static_cast<Eigen::Index>(i)));
  return fmt::format(
      "the effect of the recordings' codec on the platform's motion exceeds the interval that the data give: "
      "the intervals include it ({}, SI); film uncompressed or with less compression",
      list);
}

/// Where recordings hold fewer whole cycles than the campaign asks for.
void note_fewer_cycles(const std::vector<Run>& runs, const Context& context) {
  std::size_t count = 0;
  const Run* shortest = nullptr;
  for (const Run& run : runs) {
    if (!run.takes_part() || !run.track || run.given.free_slide ||
        run.displacement.cycles >= run.given.cycles)
      continue;
    ++count;
    if (shortest == nullptr || run.displacement.cycles < shortest->displacement.cycles) shortest = &run;
  }
  if (count > 0)
    say(context.quiet,
        fmt::format("note: {} of {} runs hold fewer whole cycles than `cycles` asks for, run \"{}\" {:g} of "
                    "cycles = {}: all that are there are used",
                    count, runs.size(), shortest->given.name,
                    static_cast<double>(shortest->displacement.cycles), shortest->given.cycles));
}

}  // namespace

void fit_runs(const Campaign& campaign, FittedCampaign& fitted, const Context& context,
              fit::FitOptions options) {
  options.threads = threads_to_use(context);
  std::map<std::string, Progress> progress;  // of each stage
  options.progress = [&](const char* name, std::size_t done, std::size_t total) {
    const std::string stage = std::string("fit, ") + name;
    progress.try_emplace(stage, stage, context)
        .first->second.update(static_cast<std::int64_t>(done), static_cast<std::int64_t>(total));
  };
  const fit::Problem problem = problem_of(campaign, fitted.runs, fitted.conditions);
  Campaign as_displacements = campaign;
  as_displacements.fit.trajectory = false;
  const auto find_slips = [&](const fit::FitResult& result) {
    return fit::find_slips(problem_of(as_displacements, fitted.runs, fitted.conditions), result,
                           typed(fitted.runs, fitted.conditions.pooled));
  };
  std::optional<std::vector<fit::SlipFound>> found;
  options.mistyped = [&](const fit::FitResult& assumed) {
    found = find_slips(assumed);
    return !found->empty();
  };
  fitted.result = fit::estimate(problem, options);
  if (!found || !fit::is_failing(fitted.result)) found = find_slips(fitted.result);
  std::vector<std::string> suspects = suspicious_runs(problem, fitted.result);
  std::vector<std::string> slips =
      likely_slips(campaign, fitted.runs, fitted.conditions, *found, fitted.result);
  const auto commanded = std::ranges::count_if(fitted.runs, [](const Run& run) {
    return run.takes_part() && run.measurement && run.measurement->phi_contradicts &&
           (!run.gate || run.gate_reference == "command");
  });
  if (commanded > 0)
    slips.push_back(
        fmt::format("in {} of {} runs the LED or the trace contradicts the commanded phi that is used",
                    commanded, fitted.runs.size()));
  const bool usable = fitted.result.verdict == fit::Use::use;
  if (!slips.empty() && usable) fitted.result.verdict = fit::Use::care;
  if (!slips.empty() && (usable || fitted.result.mistyped))
    fitted.result.verdict_reasons.push_back(slips.front());
  std::ranges::move(slips, std::back_inserter(suspects));
  fitted.result.warnings.insert(fitted.result.warnings.begin(), suspects.begin(), suspects.end());
  fitted.json = fit_json(campaign, fitted.runs, fitted.result);
  add_to(fitted.json, fitted.scale);
  add_to(fitted.json, fitted.conditions);
  for (const std::string& note : campaign.notes) say(context.quiet, "note: " + note);
  note_fewer_cycles(fitted.runs, context);
}

void write_fit(const std::filesystem::path& path, const Campaign& campaign, const FittedCampaign& fitted) {
  MetaFile meta{"fit", {campaign.input}, campaign.effective_configuration()};
  meta.inputs.insert(meta.inputs.end(), campaign.table_inputs.begin(), campaign.table_inputs.end());
  for (const Run& run : fitted.runs)
    if (run.failure.empty()) meta.inputs.insert(meta.inputs.end(), run.inputs.begin(), run.inputs.end());
  write_result(path, text_of(fitted.json), meta);
}

namespace {

/// "mu1 = 0.0995(10), ...": what the fit says of a campaign taken at its word, where the values quoted are
/// not.
std::string as_described(const fit::FitResult& result) {
  std::string text;
  for (const fit::ParameterEstimate& p : result.parameters)
    if (const auto as = result.as_assumed.find(p.parameter); as != result.as_assumed.end())
      text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", fit::to_string(p.parameter),
                          fit::quoted(as->second.estimate, as->second.sd));
  return text;
}

/// Why a fit is unusable, and what to do: one sentence for each thing the data do not determine, and the run
/// to film next.
std::vector<std::string> remedies(const fit::FitResult& result) {
  std::vector<std::string> sentences = result.identifiability.weak_directions;
  if (result.next_experiment) sentences.push_back(result.next_experiment->sentence);
  for (const fit::NextExperiment& next : result.other_next_experiments)
    if (!result.next_experiment) sentences.push_back(next.sentence);
  return sentences;
}

}  // namespace

void report_fit(const Campaign& campaign, const FittedCampaign& fitted, bool explain,
                const std::string& look_at, Context& context) {
  const fit::FitResult& result = fitted.result;
  say(context.quiet, explain ? result.full_report() : result.brief_report());
  if (explain) say(context.quiet, conditions_text(fitted.conditions.pooled) + costs_text(fitted.json));
  for (const Json& warning : fitted.json["warnings"])
    say(context.quiet, "warning: " + warning.get<std::string>());
  const std::string file = campaign.file.string();
  if (result.coder_exceeds_interval())
    context.doubt(kQualityGate, fmt::format("{}: {}", file, coding_sentence(result)));
  if (!result.quoted_under.empty())
    context.doubt(kQualityGate,
                  fmt::format("{}: the data reject the campaign as it is described (chi2 {:.4g} at {} "
                              "degrees of freedom); these values hold under {}; as described: {}",
                              file, result.chi2, result.dof, fmt::join(result.quoted_under, ", and "),
                              as_described(result)));
  if (!result.usable()) {
    std::string sentence = fmt::format("{}: do not use these values: {}; see {}", file,
                                       fmt::join(result.verdict_reasons, "; "), look_at);
    for (const std::string& remedy : remedies(result)) sentence += "\n  " + remedy;
    context.doubt(kFitUnusable, sentence);
  }
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

}  // namespace tribotrack::apps
