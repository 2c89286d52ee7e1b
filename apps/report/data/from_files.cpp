#include "apps/report/data/from_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/campaign/compared_runs.h"
#include "apps/files/run_folder.h"
#include "apps/files/scenario_file.h"
#include "apps/files/track_file.h"
#include "apps/report/data/curves.h"
#include "apps/report/data/json.h"
#include "apps/report/data/sources.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

/// The inverse of measurement_json, as far as the page shows it.
void read_measurement(const JsonPlace& m, ReportRun& run) {
  run.alpha_rad = number_at(m, "alpha_rad");
  run.alpha_sd_rad = number_at(m, "alpha_rad_sd");
  run.v_mm_s = number_at(m, "v_mm_s");
  run.v_sd_mm_s = number_at(m, "v_mm_s_sd");
  run.cycles = m.integer("cycles", 0);
  ReportPlatform& p = run.platform;
  const auto take = [](const JsonPlace& from, const std::string& name, double& value, double& sd) {
    value = number_at(from, name);
    sd = number_at(from, name + "_sd");
  };
  take(m, "amplitude_mm", p.amplitude_mm, p.amplitude_sd_mm);
  take(m, "amplitude_y_mm", p.amplitude_y_mm, p.amplitude_y_sd_mm);
  take(m, "angular_frequency_rad_s", p.w_rad_s, p.w_sd_rad_s);
  take(m, "phase_shift_rad", p.epsilon_rad, p.epsilon_sd_rad);
  p.phase_at_zero_rad = number_at(m, "phase_at_zero_rad");
  take(m, "angular_frequency_drift_rad_s2", p.drift_rad_s2, p.drift_sd_rad_s2);
  take(m, "phi_rad", p.phi_rad, p.phi_sd_rad);
  take(m, "dtau_rad", p.dtau_rad, p.dtau_sd_rad);
  if (const auto gate = m.find("gate")) {
    p.gate_source = gate->text("source");
    p.lamp_off_level = number_at(*gate, "lamp_off_level");
    p.lamp_on_level = number_at(*gate, "lamp_on_level");
  }
  for (const JsonPlace& h : m.items("harmonics")) {
    if (!h.boolean("seen", false)) continue;
    ReportHarmonic harmonic{.order = h.integer("order", 0)};
    take(h, "amplitude_mm", harmonic.amplitude_mm, harmonic.amplitude_sd_mm);
    take(h, "amplitude_y_mm", harmonic.amplitude_y_mm, harmonic.amplitude_y_sd_mm);
    p.harmonics.push_back(harmonic);
  }
}

/// PNG or JPEG, as `run` writes them.
bool is_picture(const std::vector<unsigned char>& bytes) {
  constexpr std::array<unsigned char, 4> kPng = {0x89, 'P', 'N', 'G'};
  constexpr std::array<unsigned char, 2> kJpeg = {0xff, 0xd8};
  const auto begins_with = [&](const auto& signature) {
    return bytes.size() > signature.size() && std::equal(signature.begin(), signature.end(), bytes.begin());
  };
  return begins_with(kPng) || begins_with(kJpeg);
}

/// What the page would show and is not there, by its name in the folder.
void note_missing(const RunFolder& folder, const std::string& run, const fs::path& file,
                  const char* consequence, ReportData& data) {
  data.missing.push_back(fmt::format("run {}: {} is missing: {}", run,
                                     file.lexically_relative(folder.root).string(), consequence));
}

/// Track and measurement of a run with a video; a note where they are no longer there.
void read_recording(const RunFolder& folder, ReportRun& run, ReportData& data) {
  const fs::path csv = folder.track(run.name), measurement = folder.measurement(run.name);
  Json measured = Json::object();
  if (fs::exists(measurement))
    measured = read_json(measurement);
  else if (run.kind != "free_slide")
    note_missing(folder, run.name, measurement, "what was measured in it is not shown", data);
  double used = no_value, used_sd = no_value;
  reading(measurement, [&] {
    const JsonPlace place{measured, ""};
    read_measurement(place, run);
    used = number_at(place, "mm_per_px");
    used_sd = number_at(place, "mm_per_px_sd");
  });
  if (!fs::exists(csv)) {
    note_missing(folder, run.name, csv, "its path and platform are not shown", data);
    return;
  }
  Track track = read_track_file(csv);
  if (track.mm_per_px && std::isfinite(used) && used != *track.mm_per_px) rescale(track, {used, used_sd, ""});
  add_track(track, folder, run);
  if (!run.first_frame.empty() && !is_picture(run.first_frame)) {
    run.first_frame.clear();
    data.missing.push_back(
        fmt::format("run {}: {} is no picture: it is not shown", run.name,
                    folder.first_frame(run.name).lexically_relative(folder.root).string()));
  }
  if (run.kind != "free_slide") add_drawings(track, run.platform);
  add_recording(track, data);
}

void read_given_measurement(const JsonPlace& configuration, ReportRun& run) {
  run.alpha_rad = number_at(configuration, "alpha_rad");
  run.alpha_sd_rad = number_at(configuration, "alpha_sd_rad");
  run.v_mm_s = number_at(configuration, "v_mm_s");
  run.v_sd_mm_s = number_at(configuration, "v_sd_mm_s");
  run.cycles = configuration.integer("cycles", 0);
}

std::size_t count_at(const JsonPlace& place, const std::string& key) {
  const std::int64_t count = place.whole(key, 0);
  if (count < 0) place.at(key).refuse("0 or more");
  return static_cast<std::size_t>(count);
}

/// A run as it stands in fit.json.
ReportRun read_run(const JsonPlace& entry) {
  ReportRun run;
  const JsonPlace name = entry.at("name");
  run.name = name.text();
  if (run.name.find('/') != std::string::npos) name.refuse("the name of a run, without `/`");
  run.kind = entry.at("kind").text() == "free_slide" ? "free_slide" : "displacement";
  run.failure = entry.text("failure");
  if (!run.failure.empty()) return run;
  run.phi_rad = number_at(entry, "phi_rad");
  run.dtau_rad = number_at(entry, "dtau_rad");
  run.points = count_at(entry, "points");
  if (const auto nuisance = entry.find("nuisance")) run.outlying_points = count_at(*nuisance, "outliers");
  const JsonPlace observables = entry.at("observables").list();
  for (std::size_t k = 0; k < observables.value.size(); ++k) {
    const JsonPlace r = observables.at(k);
    run.residuals.push_back({r.at("observable").text(), r.at("measured").number_or_null(),
                             r.at("modelled").number_or_null(), r.at("sd").number_or_null(),
                             r.at("standardised").number_or_null()});
    if (run.residuals.back().observable == "alpha_rad")
      run.modelled_alpha_rad = run.residuals.back().modelled;
    if (run.residuals.back().observable == "v_mm_s") run.modelled_v_mm_s = run.residuals.back().modelled;
  }
  return run;
}

/// Of the last run.
void read_influence(const JsonPlace& entry, ReportData& data) {
  if (const auto influence = entry.find("influence"))
    for (const ReportParameter& parameter : data.parameters)
      data.runs.back().influence.push_back(number_at(*influence, parameter.name));
}

/// At the fitted values; a default one where the run took no part in the fit.
model::Scenario read_scenario(const JsonPlace& entry) {
  const auto scenario = entry.find("scenario");
  if (!scenario) return {};
  try {
    return scenario_from(scenario->object().value);
  } catch (const WrongContent& error) {
    throw WrongContent(fmt::format("`{}`: {}", scenario->path, error.what()));
  }
}

ReportSlide read_slide(const JsonPlace& slide, const std::string& name) {
  return {.name = name,
          .time_s = numbers_at(slide, "time_s"),
          .position_mm = numbers_at(slide, "position_mm"),
          .sigma_mm = numbers_at(slide, "sigma_mm"),
          .fitted_mm = numbers_at(slide, "fitted_mm"),
          .sentence = slide.text("sentence")};
}

void read_runs(const RunFolder& folder, const Json& fit, const Json& meta, long most_steps,
               ReportData& data) {
  std::vector<model::Scenario> scenarios;
  std::vector<bool> took_part;
  reading(folder.fit(), [&] {
    const JsonPlace list = JsonPlace{fit, ""}.at("runs").list();
    if (list.value.empty()) list.refuse("a list with the campaign's runs");
    for (std::size_t k = 0; k < list.value.size(); ++k) {
      const JsonPlace entry = list.at(k);
      data.runs.push_back(read_run(entry));
      scenarios.push_back(read_scenario(entry));
      took_part.push_back(entry.find("scenario").has_value());
      read_influence(entry, data);
      if (const auto slide = entry.find("slide"))
        data.slides.push_back(read_slide(*slide, data.runs.back().name));
    }
  });
  for (std::size_t k = 0; k < data.runs.size(); ++k) {
    ReportRun& run = data.runs[k];
    reading(folder.fit().string() + ".meta.json", [&] {
      const JsonPlace configuration = JsonPlace{meta, ""}.at("configuration").at("runs").at(k);
      run.video = configuration.text("video");
      if (run.video.empty()) run.video = configuration.text("track");
      if (run.failure.empty()) add_pooled_note(configuration.texts("pooled_from"), run);
      if (run.video.empty() && run.failure.empty()) read_given_measurement(configuration, run);
    });
    if (run.failure.empty() && !run.video.empty()) read_recording(folder, run, data);
    if (took_part[k] && !add_model_path(scenarios[k], run.in_camera_frame, run))
      note_no_model_path(run, data);
  }
  add_curves(scenarios, data, most_steps);
}

[[noreturn]] void refuse_file(const fs::path& file) {
  if (file.filename() == "fit.json")
    throw InvalidInput(
        fmt::format("{}: is no folder; name the folder that `run` filled: `tribotrack report {} -o r.html`",
                    file.string(), file.has_parent_path() ? file.parent_path().string() : "."));
  throw InvalidInput(fmt::format(
      "{}: is no folder; name one that `tribotrack run CAMPAIGN.toml -o DIR` filled", file.string()));
}

}  // namespace

ReportData data_from_files(const RunFolder& folder, long most_steps) {
  if (fs::exists(folder.root) && !fs::is_directory(folder.root)) refuse_file(folder.root);
  if (!fs::exists(folder.fit()))
    throw InvalidInput(
        fmt::format("{}: holds no fit.json; make one with `tribotrack run CAMPAIGN.toml -o {}`",
                    folder.root.string(), folder.root.string()));
  const fs::path meta_file = folder.fit().string() + ".meta.json";
  if (!fs::exists(meta_file))
    throw InvalidInput(
        fmt::format("{}: is missing, and with it the campaign's configuration; run it again: `tribotrack run "
                    "CAMPAIGN.toml -o {}`",
                    meta_file.string(), folder.root.string()));
  const Json fit = read_json(folder.fit());
  const Json meta = read_json(meta_file);
  ReportData data;
  reading(folder.fit(), [&] { read_fit(fit, data); });
  reading(meta_file, [&] {
    JsonPlace{meta, ""}.at("schema").integer();
    require_known_schema(meta, meta_file);
    add_provenance(meta, data);
  });
  read_runs(folder, fit, meta, most_steps, data);
  data.warnings.insert(data.warnings.end(), data.missing.begin(), data.missing.end());
  return data;
}

}  // namespace tribotrack::apps
