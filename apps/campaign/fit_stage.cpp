#include "apps/campaign/fit_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <string>
#include <utility>

#include "apps/campaign/compared_runs.h"
#include "apps/campaign/fit_json.h"
#include "apps/campaign/slips.h"
#include "apps/files/run_folder.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"
#include "fit/rounding.h"

namespace tribotrack::apps {

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

namespace {

using fit::FitParameter;

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

/// What a lossy coder does to the parameters.
std::string coding_sentence(const fit::FitResult& result) {
  std::string list;
  const Eigen::VectorXd sd = result.sd_from(fit::kFromCoder);
  for (std::size_t i = 0; i < result.parameters.size(); ++i)
    list += fmt::format("{}{} +- {:.2g}", i > 0 ? ", " : "", fit::to_string(result.parameters[i].parameter),
                        sd(static_cast<Eigen::Index>(i)));
  return fmt::format(
      "the effect of the recordings' codec on the platform's motion exceeds the interval that the data give: "
      "the intervals include it ({}, SI); film uncompressed or all-intra",
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
                    "cycles = {}: "
                    "all that are there are used",
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
    progress.try_emplace(stage, stage, context.quiet)
        .first->second.update(static_cast<std::int64_t>(done), static_cast<std::int64_t>(total));
    context.tell(stage, static_cast<std::int64_t>(done), static_cast<std::int64_t>(total));
  };
  const fit::Problem problem = problem_of(campaign, fitted.runs, fitted.conditions);
  fitted.result = fit::estimate(problem, options);
  std::vector<std::string> suspects = suspicious_runs(problem, fitted.result);
  Campaign as_displacements = campaign;
  as_displacements.fit.trajectory = false;
  std::vector<std::string> slips =
      likely_slips(campaign, fitted.runs, fitted.conditions,
                   problem_of(as_displacements, fitted.runs, fitted.conditions), fitted.result);
  if (!slips.empty() && fitted.result.verdict == fit::Use::use) {
    fitted.result.verdict = fit::Use::care;
    fitted.result.verdict_reasons.push_back(slips.front());
  }
  std::ranges::move(slips, std::back_inserter(suspects));
  fitted.result.warnings.insert(fitted.result.warnings.begin(), suspects.begin(), suspects.end());
  fitted.json = fit_json(campaign, fitted.runs, fitted.result);
  add_to(fitted.json, fitted.scale);
  add_to(fitted.json, fitted.conditions);
  for (const std::string& note : campaign.notes) say(context.quiet, "note: " + note);
  note_fewer_cycles(fitted.runs, context);
}

MetaFile write_fit(const std::filesystem::path& path, const Campaign& campaign,
                   const FittedCampaign& fitted) {
  MetaFile meta;
  meta.command = "fit";
  meta.inputs = {campaign.input};
  meta.inputs.insert(meta.inputs.end(), campaign.table_inputs.begin(), campaign.table_inputs.end());
  for (const Run& run : fitted.runs)
    if (run.failure.empty()) meta.inputs.insert(meta.inputs.end(), run.inputs.begin(), run.inputs.end());
  meta.configuration = campaign.effective_configuration();
  write_result(path, text_of(fitted.json), meta);
  return meta;
}

namespace {

std::string chi2_text(const fit::FitResult& result) {
  return fmt::format("chi2 {:.4g} at {} degrees of freedom", result.chi2, result.dof);
}

}  // namespace

std::string as_described(const fit::FitResult& result) {
  std::string text;
  for (const fit::ParameterEstimate& p : result.parameters)
    if (const auto as = result.as_assumed.find(p.parameter); as != result.as_assumed.end())
      text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", fit::to_string(p.parameter),
                          fit::quoted(as->second.estimate, as->second.sd));
  return text;
}

std::vector<Reservation> reservations(const Campaign& campaign, const FittedCampaign& fitted,
                                      const std::string& look_at) {
  const fit::FitResult& result = fitted.result;
  std::vector<Reservation> found;
  if (result.coder_exceeds_interval())
    found.push_back(
        {kQualityGate, fmt::format("{}: {}", campaign.file.string(), coding_sentence(result)), {}});
  if (!result.quoted_under.empty())
    found.push_back(
        {kQualityGate,
         fmt::format("{}: the data reject the campaign as it is described ({}); these values hold "
                     "under {}; as described: {}",
                     campaign.file.string(), chi2_text(result),
                     fmt::format("{}", fmt::join(result.quoted_under, ", and ")), as_described(result)),
         {}});
  if (!result.usable())
    found.push_back({kFitUnusable,
                     fmt::format("{}: do not use these values: {}; see {}", campaign.file.string(),
                                 fmt::format("{}", fmt::join(result.verdict_reasons, "; ")), look_at),
                     remedies(result)});
  return found;
}

void report_fit(const Campaign& campaign, const FittedCampaign& fitted, bool explain,
                const std::string& look_at, Context& context) {
  say(context.quiet, explain ? fitted.result.full_report() : fitted.result.brief_report());
  if (explain) say(context.quiet, conditions_text(fitted.conditions.pooled) + costs_text(fitted.json));
  for (const Json& warning : fitted.json["warnings"])
    say(context.quiet, "warning: " + warning.get<std::string>());
  for (const Reservation& reservation : reservations(campaign, fitted, look_at)) {
    complain(reservation.sentence);
    for (const std::string& sentence : reservation.remedies) print_error("  " + sentence);
    context.exit_code = reservation.exit_code;
  }
}

}  // namespace tribotrack::apps
