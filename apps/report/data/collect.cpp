#include "apps/report/data/collect.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>

#include "apps/files/meta_file.h"
#include "apps/files/scenario_file.h"
#include "apps/files/track_file.h"
#include "apps/program/errors.h"
#include "apps/report/data/fit.h"
#include "apps/report/data/groups.h"
#include "apps/report/data/json.h"
#include "apps/report/page/page.h"
#include "apps/report/page/platform.h"
#include "fit/estimate.h"
#include "model/alpha_v.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

std::string error_bound_text(double px) {
  if (std::isnan(px)) return "not known";
  return px == 0 ? "none: exact" : fmt::format("{:.2g} px", px);
}

void collect_track(const RunFolder& folder, ReportRun& run) {
  const fs::path csv = folder.track(run.name);
  if (!fs::exists(csv)) return;
  const TrackFile track = read_track_file(csv);
  if (run.kind != "free_slide") run.platform = platform_of(track);
  run.x_px = track.x_px;
  run.y_px = track.y_px;
  run.x_mm = track.x_mm;
  run.y_mm = track.y_mm;
  run.frames_ok = track.frames - track.lost - track.edge;
  run.frames_lost = track.lost;
  run.frames_edge = track.edge;
  std::vector<double> sigmas;
  std::copy_if(track.sigma_px.begin(), track.sigma_px.end(), std::back_inserter(sigmas),
               [](double s) { return std::isfinite(s); });
  if (!sigmas.empty()) {
    const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
    std::nth_element(sigmas.begin(), middle, sigmas.end());
    run.sigma_px = *middle;
  }
  if (track.meta.is_object()) {
    const Json& meta = track.meta;
    run.video = fs::path(meta.at("inputs").at(0).at("path").get<std::string>()).filename().string();
    run.frame_rate_hz = number_at(meta.at("time_base"), "rate_hz");
    run.time_base = word_at(meta.at("time_base"), "source");
    run.frame_width_px = meta.at("recording").at("width").get<int>();
    run.frame_height_px = meta.at("recording").at("height").get<int>();
    if (const Json& scale = meta.at("scale"); scale.is_object()) {
      run.mm_per_px = number_at(scale, "mm_per_px");
      run.scale_source = word_at(scale, "source");
    }
    if (word_at(meta, "frame_of_reference") == "camera" && run.kind != "free_slide")
      run.notes.push_back("measured in the camera's frame: no marker");
    for (const std::string& note : sentences_at(meta.at("summary"), "warnings")) run.notes.push_back(note);
    for (const Json& stage : meta.at("plan"))
      run.plan.push_back({word_at(stage, "stage"), stage.at("on").get<bool>(), word_at(stage, "reason"),
                          error_bound_text(number_at(stage, "error_bound_px"))});
  }
  if (fs::exists(folder.first_frame(run.name))) {
    std::ifstream picture(folder.first_frame(run.name), std::ios::binary);
    run.first_frame.assign(std::istreambuf_iterator<char>(picture), {});
  }
}

void collect_measurement(const RunFolder& folder, ReportRun& run) {
  if (!fs::exists(folder.measurement(run.name))) return;
  const Json m = read_json(folder.measurement(run.name));
  run.alpha_rad = number_at(m, "alpha_rad");
  run.alpha_sd_rad = number_at(m, "alpha_rad_sd");
  run.v_mm_s = number_at(m, "v_mm_s");
  run.v_sd_mm_s = number_at(m, "v_mm_s_sd");
  run.cycles = m.value("cycles", 0);
  ReportPlatform& p = run.platform;
  const auto take = [&](const char* name, double& value, double& sd) {
    value = number_at(m, name);
    sd = number_at(m, std::string(name) + "_sd");
  };
  take("amplitude_mm", p.amplitude_mm, p.amplitude_sd_mm);
  take("amplitude_y_mm", p.amplitude_y_mm, p.amplitude_y_sd_mm);
  take("angular_frequency_rad_s", p.w_rad_s, p.w_sd_rad_s);
  take("phase_shift_rad", p.epsilon_rad, p.epsilon_sd_rad);
  take("angular_frequency_drift_rad_s2", p.drift_rad_s2, p.drift_sd_rad_s2);
  take("phi_rad", p.phi_rad, p.phi_sd_rad);
  take("dtau_rad", p.dtau_rad, p.dtau_sd_rad);
  if (const auto gate = m.find("gate"); gate != m.end()) p.gate_source = word_at(*gate, "source");
  if (const auto harmonics = m.find("harmonics"); harmonics != m.end())
    for (const Json& h : *harmonics)
      if (h.value("seen", false))
        p.harmonics.push_back(fmt::format("{}ω: {:.3g} ± {:.1g} mm along x, {:.3g} ± {:.1g} mm along y",
                                          h.value("order", 0), number_at(h, "amplitude_mm"),
                                          number_at(h, "amplitude_mm_sd"), number_at(h, "amplitude_y_mm"),
                                          number_at(h, "amplitude_y_mm_sd")));
}

ReportSlide slide_of(const Json& run) {
  const Json& slide = run.at("slide");
  ReportSlide report;
  report.name = word_at(run, "name");
  report.time_s = numbers_at(slide, "time_s");
  report.position_mm = numbers_at(slide, "position_mm");
  report.sigma_mm = numbers_at(slide, "sigma_mm");
  report.fitted_mm = numbers_at(slide, "fitted_mm");
  report.sentence = word_at(slide, "sentence");
  return report;
}

ReportRun run_of(const Json& entry, const Json& configuration, const RunFolder& folder) {
  ReportRun run;
  run.name = word_at(entry, "name");
  run.kind = word_at(entry, "kind") == "free_slide" ? "free_slide" : "displacement";
  run.failure = word_at(entry, "failure");
  run.phi_rad = number_at(entry, "phi_rad");
  run.dtau_rad = number_at(entry, "dtau_rad");
  collect_track(folder, run);
  collect_measurement(folder, run);
  if (run.video.empty() && !std::isfinite(run.alpha_rad)) {  // measured elsewhere
    run.alpha_rad = number_at(configuration, "alpha_rad");
    run.alpha_sd_rad = number_at(configuration, "alpha_sd_rad");
    run.v_mm_s = number_at(configuration, "v_mm_s");
    run.v_sd_mm_s = number_at(configuration, "v_sd_mm_s");
    run.cycles = configuration.value("cycles", 0);
  }
  run.points = entry.value("points", std::size_t{0});
  if (const auto nuisance = entry.find("nuisance"); nuisance != entry.end())
    run.outlying_points = static_cast<std::size_t>(nuisance->value("outliers", 0.0));
  if (const auto residuals = entry.find("observables"); residuals != entry.end())
    for (const Json& r : *residuals) {
      run.residuals.push_back({word_at(r, "observable"), number_at(r, "measured"), number_at(r, "modelled"),
                               number_at(r, "sd"), number_at(r, "standardised")});
      if (run.residuals.back().observable == "alpha_rad") run.modelled_alpha_rad = number_at(r, "modelled");
      if (run.residuals.back().observable == "v_mm_s") run.modelled_v_mm_s = number_at(r, "modelled");
    }
  return run;
}

/// The model's alpha and v through a group of runs: the scenario of its first run with one angle varied.
void draw_curve(ReportGroup& group, const std::vector<model::Scenario>& scenarios, bool over_phi) {
  model::Scenario scenario = scenarios[group.runs.front()];
  for (const double x : group.curve_x_rad) {
    (over_phi ? scenario.friction.phase : scenario.friction.pulse_width) = x;
    const Eigen::Vector2d displacement = fit::modelled_displacement(scenario);
    const bool moved = displacement.norm() > 0;
    group.curve_alpha_rad.push_back(moved ? model::displacement_angle(displacement) : no_value);
    group.curve_v_mm_s.push_back(model::mean_velocity(displacement, scenario.end_time()) * 1e3);
  }
}

void collect_curves(const std::vector<model::Scenario>& scenarios, ReportData& data) {
  data.over_phi = group_over_phi(data.runs);
  for (ReportGroup& group : data.over_phi) {
    group.curve_x_rad = curve_phis(group, data.runs);
    draw_curve(group, scenarios, true);
  }
  data.over_dtau = group_over_dtau(data.runs);
  for (ReportGroup& group : data.over_dtau) {
    group.curve_x_rad = curve_dtaus(group, data.runs);
    draw_curve(group, scenarios, false);
  }
}

void collect_given(const Json& configuration, const Json& fit, ReportData& data) {
  const auto& fitted = fit.at("parameters");
  for (const char* section : {"platform", "part"})
    if (const auto found = configuration.find(section); found != configuration.end())
      for (const auto& [name, value] : found->items())
        if (value.is_number() && !fitted.contains(name))
          data.given.push_back({name, value.get<double>(), "campaign"});
  for (const auto& [name, value] : configuration.at("fit").at("fixed").items())
    data.given.push_back({name, value.get<double>(), "campaign, held fixed"});
}

}  // namespace

ReportData collect_report(const RunFolder& folder) {
  if (!fs::exists(folder.fit()))
    throw InvalidInput(
        fmt::format("{}: holds no fit.json; make one with `tribotrack run CAMPAIGN.toml -o {}`",
                    folder.root.string(), folder.root.string()));
  const Json fit = read_json(folder.fit());
  const Json meta = read_json(folder.fit().string() + ".meta.json");
  ReportData data;
  try {
    const Json& configuration = meta.at("configuration");
    collect_fit(fit, data);
    collect_given(configuration, fit, data);
    std::vector<model::Scenario> scenarios;
    const Json& runs = fit.at("runs");
    for (std::size_t k = 0; k < runs.size(); ++k) {
      data.runs.push_back(run_of(runs[k], configuration.at("runs").at(k), folder));
      scenarios.push_back(runs[k].contains("scenario") ? scenario_from(runs[k].at("scenario"))
                                                       : model::Scenario{});
      if (runs[k].contains("slide")) data.slides.push_back(slide_of(runs[k]));
    }
    collect_curves(scenarios, data);
    data.program_version = word_at(meta, "version");
    for (const Json& input : meta.at("inputs"))
      data.inputs.push_back(
          {fs::path(word_at(input, "path")).filename().string(), "xxh3-128:" + word_at(input, "xxh3_128")});
    for (const ReportRun& run : data.runs)
      if (fs::exists(folder.track(run.name)))
        for (const Json& input : read_json(folder.track(run.name).string() + ".meta.json").at("inputs"))
          data.inputs.push_back({fs::path(word_at(input, "path")).filename().string(),
                                 "xxh3-128:" + word_at(input, "xxh3_128")});
    data.configuration = configuration.dump(2);
  } catch (const Json::exception& error) {
    throw InvalidInput(
        fmt::format("{}: is not what this version of `tribotrack run` writes ({}); run it again",
                    folder.fit().string(), error.what()));
  }
  return data;
}

std::string report_page_of(const RunFolder& folder) {
  return render_report(collect_report(folder));
}

}  // namespace tribotrack::apps
