#include "apps/report/data/from_results.h"

#include <cmath>

#include "apps/campaign/fit_json.h"
#include "apps/campaign/fit_stage.h"
#include "apps/files/scenario_file.h"
#include "apps/report/data/curves.h"
#include "apps/report/data/json.h"
#include "apps/report/data/sources.h"

namespace tribotrack::apps {
namespace {

// Every value is the one that the result files hold, by the same arithmetic: a later `report` gives the same
// page.

/// Result files hold no infinite numbers.
double finite(double value) {
  return std::isfinite(value) ? value : no_value;
}

/// An end that is not finite is an open one.
ReportInterval interval(const fit::Interval& range, double unit) {
  constexpr double open = std::numeric_limits<double>::infinity();
  const double low = range.low * unit, high = range.high * unit;
  return {std::isfinite(low) ? low : -open, std::isfinite(high) ? high : open};
}

void take(const fit::Estimate& estimate, double& value, double& sd, double unit = 1) {
  value = finite(estimate.value / unit);
  sd = finite(estimate.sd / std::abs(unit));
}

void add_parameters(const fit::FitResult& fit, double mm_per_px, ReportData& data) {
  for (const fit::ParameterEstimate& p : fit.parameters) {
    const double unit = campaign_unit_per_si(p.parameter, mm_per_px);
    data.parameters.push_back({.name = fit::to_string(p.parameter),
                               .estimate = finite(p.estimate * unit),
                               .sd = finite(p.sd * unit),
                               .ci95 = interval(p.ci95, unit),
                               .pieces = {},
                               .covariance_ci95 = interval(p.covariance_ci95, unit),
                               .profile_ci95 = interval(p.profile_ci95, unit)});
    if (p.ci95_pieces.size() > 1)
      for (const fit::Interval& piece : p.ci95_pieces)
        data.parameters.back().pieces.push_back(interval(piece, unit));
    ReportProfile& profile = data.parameters.back().profile;
    if (!p.profile.empty()) profile.level = p.profile_level;
    for (const fit::ProfilePoint& point : p.profile) {
      profile.value.push_back(finite(point.value * unit));
      profile.rise.push_back(finite(point.rise));
    }
    if (fit.bootstrap > 0) data.parameters.back().bootstrap_ci95 = interval(p.bootstrap_ci95, unit);
  }
  for (Eigen::Index i = 0; i < fit.correlation.rows(); ++i) {
    data.correlation.emplace_back();
    for (Eigen::Index j = 0; j < fit.correlation.cols(); ++j)
      data.correlation.back().push_back(finite(fit.correlation(i, j)));
  }
}

ReportVerdict verdict_of(const fit::Identifiability& identifiability) {
  switch (identifiability.verdict) {
    case fit::Verdict::identifiable:
      return ReportVerdict::identifiable;
    case fit::Verdict::weak:
      return ReportVerdict::weak;
    case fit::Verdict::not_identifiable:
      break;
  }
  return ReportVerdict::not_identifiable;
}

void add_checks(const fit::FitResult& fit, ReportData& data) {
  data.p_value = finite(fit.p_value);
  data.runs_test_p_value = finite(fit.runs_test_p_value);
  for (const fit::Outlier& outlier : fit.outliers)
    data.outliers.push_back({outlier.run, finite(outlier.deviation), finite(outlier.chance),
                             outlier.looks_like_phi.value_or(no_value)});
  for (const fit::ModelComparison& model : fit.models)
    data.models.push_back({model.name, model.parameters, finite(model.chi2), finite(model.aic),
                           finite(model.bic), model.sentence});
  data.left_out = fit.left_out;
  data.systematics = fit.systematics;
  data.improve_first = fit.improve_first;
  data.scatter_dominates = fit.scatter_dominates;
  for (std::size_t k = 1; k < fit.minima.size(); ++k) data.other_minima.push_back(fit.minima[k].sentence);
  data.bootstrap_refits = fit.bootstrap;
  if (fit.bootstrap > 0) data.bootstrap_seed = fit.bootstrap_seed;
}

void add_slide_results(const fit::FitResult& fit, ReportData& data) {
  for (const fit::SlideResult& s : fit.slides) {
    ReportSlideResult slide{.name = s.run,
                            .mu1 = finite(s.mu1.value),
                            .mu1_sd = finite(s.mu1.sd),
                            .ci95 = interval(s.ci95, 1),
                            .chi2 = finite(s.chi2),
                            .p_value = finite(s.p_value),
                            .dof = s.dof,
                            .first_frame = s.first_frame,
                            .last_frame = s.last_frame,
                            .spin_seen = s.spin_seen,
                            .blow_frames = {},
                            .sentence = s.sentence};
    if (s.spin_seen) {
      take(s.spin, slide.spin_rad_s, slide.spin_rad_s_sd);
      take(s.spin_ratio, slide.spin_ratio, slide.spin_ratio_sd);
    } else {
      slide.slope_rad = s.slope;
      slide.change_by_half_spin = finite(s.change_by_half_spin);
    }
    for (const fit::Blow& blow : s.blows) slide.blow_frames.push_back(blow.frame);
    data.slide_results.push_back(std::move(slide));
  }
  data.between_slides = fit.between_slides;
  if (fit.slides.size() > 1) data.between_slides_p_value = finite(fit.between_slides_p_value);
}

ReportNextRun next_run(const fit::NextExperiment& next, const fit::FitResult& fit, double mm_per_px) {
  ReportNextRun run{.phi_rad = finite(next.phi),
                    .dtau_rad = finite(next.dtau),
                    .amplitude_mm = finite(next.amplitude * 1e3),
                    .w_rad_s = finite(next.angular_frequency),
                    .aim = next.aim ? fit::to_string(*next.aim) : "",
                    .predicted_ci95 = {},
                    .sentence = next.sentence};
  for (const fit::ParameterEstimate& p : fit.parameters) {
    const auto found = next.predicted_ci95.find(p.parameter);
    run.predicted_ci95.push_back(found == next.predicted_ci95.end()
                                     ? ReportInterval{}
                                     : interval(found->second, campaign_unit_per_si(p.parameter, mm_per_px)));
  }
  return run;
}

void add_fit(const ReportInput& input, ReportData& data) {
  const fit::FitResult& fit = input.fit;
  const double mm_per_px = reference_mm_per_px(input.runs);
  data.converged = fit.converged;
  data.chi2 = finite(fit.chi2);
  data.dof = fit.dof;
  data.agreement = fit.agreement;
  data.scatter_mm = finite(fit.scatter * 1e3);
  data.covariance_meaning = fit.covariance_meaning;
  data.identifiability = verdict_of(fit.identifiability);
  data.weak_directions = fit.identifiability.weak_directions;
  data.phase_reference = phase_reference(input.campaign, input.runs);
  data.warnings = warnings_of(input.campaign, input.runs, fit);
  if (const auto& scale = input.shared.scale) {
    data.shared_scale = scale->finding;
    if (!scale->used) data.warnings.push_back(scale->finding);
  }
  const SharedConditions& conditions = input.shared.conditions;
  data.warnings.insert(data.warnings.end(), conditions.warnings.begin(), conditions.warnings.end());
  read_conditions({conditions_json(conditions.table), "conditions"}, data);
  add_parameters(fit, mm_per_px, data);
  add_checks(fit, data);
  read_budget({budget_json(fit, mm_per_px), "budget"}, data);
  add_slide_results(fit, data);
  if (fit.next_experiment) {
    data.next_experiment = fit.next_experiment->sentence;
    data.next_runs.push_back(next_run(*fit.next_experiment, fit, mm_per_px));
  }
  for (const fit::NextExperiment& next : fit.other_next_experiments)
    data.next_runs.push_back(next_run(next, fit, mm_per_px));
}

/// As measurement_json writes it: the scale's sd counted in.
void add_measurement(const RunMeasurement& m, const Track& track, ReportRun& run) {
  const double scale_sd = track.mm_per_px ? track.mm_per_px_sd.value_or(0) / *track.mm_per_px : 0;
  if (m.displacement) {
    const fit::Displacement d = fit::with_scale_sd(*m.displacement, scale_sd);
    if (d.alpha) take(*d.alpha, run.alpha_rad, run.alpha_sd_rad);
    take(d.mean_velocity, run.v_mm_s, run.v_sd_mm_s, 1e-3);
    run.cycles = d.cycles;
  }
  ReportPlatform& p = run.platform;
  if (m.platform) {
    const fit::PlatformMotion platform = fit::with_scale_sd(*m.platform, scale_sd);
    take(platform.amplitude, p.amplitude_mm, p.amplitude_sd_mm, 1e-3);
    take(platform.amplitude_y, p.amplitude_y_mm, p.amplitude_y_sd_mm, 1e-3);
    take(m.platform->angular_frequency, p.w_rad_s, p.w_sd_rad_s);
    take(m.platform->phase_shift, p.epsilon_rad, p.epsilon_sd_rad);
    p.phase_at_zero_rad = finite(m.platform->phase_at_zero.value);
    if (m.platform->frequency_drift) take(*m.platform->frequency_drift, p.drift_rad_s2, p.drift_sd_rad_s2);
    for (const fit::Harmonic& h : m.platform->harmonics) {
      if (!h.seen()) continue;
      ReportHarmonic harmonic{.order = h.order};
      take(h.amplitude, harmonic.amplitude_mm, harmonic.amplitude_sd_mm, 1e-3);
      take(h.amplitude_y, harmonic.amplitude_y_mm, harmonic.amplitude_y_sd_mm, 1e-3);
      p.harmonics.push_back(harmonic);
    }
  } else if (m.angular_frequency) {
    take(*m.angular_frequency, p.w_rad_s, p.w_sd_rad_s);
  }
  if (m.gate) {
    take(m.gate->phi, p.phi_rad, p.phi_sd_rad);
    take(m.gate->dtau, p.dtau_rad, p.dtau_sd_rad);
    p.gate_source = m.gate->source;
    if (lamp_gave_phi(*m.gate)) {
      p.lamp_off_level = finite(m.gate->off_level);
      p.lamp_on_level = finite(m.gate->on_level);
    }
  }
}

void add_residuals(const fit::RunResult& result, ReportRun& run) {
  for (const fit::Residual& r : result.residuals) {
    run.residuals.push_back(
        {r.observable, finite(r.measured), finite(r.modelled), finite(r.sd), finite(r.standardised)});
    if (r.observable == "alpha_rad") run.modelled_alpha_rad = finite(r.modelled);
    if (r.observable == "v_mm_s") run.modelled_v_mm_s = finite(r.modelled);
  }
  run.points = result.points;
  for (const double change : result.influence) run.influence.push_back(finite(change));
  if (const auto outliers = result.nuisance.find("outliers"); outliers != result.nuisance.end())
    run.outlying_points = static_cast<std::size_t>(outliers->second);
}

ReportSlide slide_of(const fit::RunResult& result) {
  ReportSlide slide;
  slide.name = result.name;
  slide.time_s = result.slide.time;
  for (const double m : result.slide.measured) slide.position_mm.push_back(finite(m * 1e3));
  for (const double m : result.slide.modelled) slide.fitted_mm.push_back(finite(m * 1e3));
  slide.sentence = slide_sentence(result);
  return slide;
}

/// Conditions and measurement of one run, without the fit's part.
ReportRun run_of(const Run& analysed, const RunFolder& folder, ReportData& data) {
  const CampaignRun& given = analysed.given;
  ReportRun run;
  run.name = given.name;
  run.kind = given.free_slide ? "free_slide" : "displacement";
  run.video = given.video   ? given.video->filename().string()
              : given.track ? given.track->filename().string()
                            : "";
  run.failure = analysed.failure;
  if (!run.failure.empty()) return run;
  if (!given.free_slide) {
    run.phi_rad = finite(analysed.scenario.friction.phase);
    run.dtau_rad = finite(analysed.scenario.friction.pulse_width);
  }
  add_pooled_note(given.pooled_from, run);
  if (given.alpha) {
    run.alpha_rad = *given.alpha;
    run.alpha_sd_rad = *given.alpha_sd;
    run.v_mm_s = *given.v * 1e3;
    run.v_sd_mm_s = *given.v_sd * 1e3;
    run.cycles = given.cycles;
  }
  if (!analysed.track) return run;
  if (analysed.measurement) add_measurement(*analysed.measurement, *analysed.track, run);
  add_track(*analysed.track, folder, run);
  if (!given.free_slide) add_drawings(*analysed.track, run.platform);
  add_recording(*analysed.track, data);
  return run;
}

void add_runs(const ReportInput& input, ReportData& data) {
  std::vector<model::Scenario> scenarios;
  for (const Run& analysed : input.runs) {
    ReportRun run = run_of(analysed, input.folder, data);
    model::Scenario scenario;
    for (const fit::RunResult& result : input.fit.runs) {
      if (result.name != run.name || !run.failure.empty()) continue;
      add_residuals(result, run);
      // In the units of fit.json, where a conversion costs the last bit.
      scenario = scenario_from(json_of(result.fitted));
      if (!add_model_path(scenario, run.in_camera_frame, run)) note_no_model_path(run, data);
      if (!result.slide.time.empty()) data.slides.push_back(slide_of(result));
    }
    data.runs.push_back(std::move(run));
    scenarios.push_back(scenario);
  }
  add_curves(scenarios, data);
}

}  // namespace

ReportData data_from_results(const ReportInput& input) {
  ReportData data;
  add_fit(input, data);
  add_provenance(input.meta, data);
  add_runs(input, data);
  return data;
}

}  // namespace tribotrack::apps
