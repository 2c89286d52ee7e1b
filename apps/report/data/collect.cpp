#include "apps/report/data/data.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>

#include "apps/campaign/compared_runs.h"
#include "apps/program/errors.h"
#include "apps/report/data/curves.h"
#include "fit/fit_result_json.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

/// Runs `read`; what it misses becomes an InvalidInput that names the file, too.
template <class Read>
auto reading(const fs::path& file, const Read& read) {
  try {
    return read();
  } catch (const WrongContent& error) {
    throw InvalidInput(file.string() + ": " + error.what() +
                       "; it is not what `tribotrack run` writes: run it again");
  }
}

/// NaN where there is no number.
double number_at(const JsonPlace& place, const std::string& key) {
  return place.number(key, no_value);
}

// From the meta file.

/// A campaign by its file's name, or by its folder's where the file is just called campaign.toml.
std::string title_of(const fs::path& campaign) {
  const std::string folder = campaign.parent_path().filename().string();
  const bool plain = campaign.stem() == "campaign" && !folder.empty() && folder != "." && folder != "..";
  return plain ? folder : campaign.stem().string();
}

/// "6 × 0.8 mm", as far as it was given.
std::string part_text(const JsonPlace& configuration) {
  const auto part = configuration.find("part");
  if (!part) return "";
  const double diameter = number_at(*part, "diameter_mm"), height = number_at(*part, "height_mm");
  if (std::isnan(diameter)) return "";
  return std::isnan(height) ? fmt::format("⌀ {:g} mm", diameter)
                            : fmt::format("⌀ {:g} × {:g} mm", diameter, height);
}

bool is_sd(const std::string& name) {
  return name.ends_with("_sd");
}

/// What is neither fitted nor pooled stands beside the pooled conditions as it was given.
void add_given(const JsonPlace& configuration, ReportData& data) {
  const std::vector<ReportCondition> pooled = data.conditions;
  const auto add = [&](const std::string& name, double value, const std::string& from) {
    if (std::ranges::find(pooled, name, &ReportCondition::quantity) == pooled.end())
      data.conditions.push_back({.quantity = name, .given = value, .used = value, .from = from});
  };
  const auto fitted = [&](const std::string& name) {
    return std::ranges::any_of(data.fit.parameters,
                               [&](const auto& p) { return name == fit::to_string(p.parameter); });
  };
  for (const char* section : {"platform", "part"})
    if (const auto found = configuration.find(section))
      for (const auto& [name, value] : found->object().value.items()) {
        if (!value.is_number() || fitted(name) || is_sd(name)) continue;
        const double sd = number_at(*found, name + "_sd");
        add(name, value.get<double>(),
            sd > 0 ? fmt::format("campaign, sd {:.3g}", sd) : "campaign, no sd given");
      }
  const JsonPlace fixed = configuration.at("fit").at("fixed").object();
  for (const auto& item : fixed.value.items())
    add(item.key(), fixed.at(item.key()).number(), "campaign, held fixed");
}

void read_meta(const Json& meta, const fs::path& file, ReportData& data) {
  const JsonPlace place{meta, ""};
  place.at("schema").integer();
  require_known_schema(meta, file);
  const JsonPlace configuration = place.at("configuration");
  add_given(configuration, data);
  data.program_version = place.text("version");
  data.part = part_text(configuration);
  const JsonPlace inputs = place.at("inputs").list();
  for (const JsonPlace& input : inputs.items())
    data.inputs.push_back({input.at("path").text(), input.at("xxh3_128").text(), input.text("hashed")});
  if (!data.inputs.empty()) data.title = title_of(inputs.at(std::size_t{0}).at("path").text());
  if (const std::string title = configuration.text("title"); !title.empty()) data.title = title;
  data.configuration = configuration.value.dump(2, ' ', false, Json::error_handler_t::replace);
}

// From fit.json.

void read_fit(const Json& json, ReportData& data) {
  const JsonPlace place{json, ""};
  data.fit = json.get<fit::FitResult>();
  data.warnings = std::exchange(data.fit.warnings, {});
  data.exact = place.texts("taken_as_exact");
  data.phase_reference = place.text("phase_reference");
  if (const auto shared = place.find("shared_scale")) data.shared_scale = shared->text("finding");
  for (const JsonPlace& row : place.items("conditions"))
    data.conditions.push_back({.quantity = row.text("quantity"),
                               .given = number_at(row, "given"),
                               .given_sd = number_at(row, "given_sd"),
                               .measured = number_at(row, "measured"),
                               .sd = number_at(row, "sd"),
                               .difference_in_sd = number_at(row, "difference_in_sd"),
                               .used = number_at(row, "used"),
                               .used_sd = number_at(row, "used_sd"),
                               .from = row.text("from")});
  // Its runs, each with its part of the fit.
  const JsonPlace list = place.at("runs").list();
  if (list.value.empty()) list.refuse("a list with the campaign's runs");
  auto fitted = data.fit.runs.begin();
  for (const JsonPlace& entry : list.items()) {
    ReportRun& run = data.runs.emplace_back();
    const JsonPlace name = entry.at("name");
    run.name = name.text();
    if (run.name.find('/') != std::string::npos) name.refuse("the name of a run, without `/`");
    run.free_slide = entry.at("kind").text() == "free_slide";
    run.failure = entry.text("failure");
    if (entry.find("scenario")) run.fitted = std::move(*fitted++);
    if (!run.failure.empty()) continue;
    entry.at("observables").list();
    run.phi_rad = number_at(entry, "phi_rad");
    run.dtau_rad = number_at(entry, "dtau_rad");
  }
  data.fit.runs.clear();
}

// Of each run.

/// The median; NaN where none is finite.
double median_of_finite(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return no_value;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What the page would show and is not there, by its name in the folder.
void note_missing(const RunFolder& folder, const std::string& run, const fs::path& file,
                  const std::string& consequence, ReportData& data) {
  data.missing.push_back(
      fmt::format("run {}: {} {}", run, file.lexically_relative(folder.root).string(), consequence));
}

/// The object of measurements/NAME.json.
void add_measurement(const JsonPlace& m, ReportRun& run) {
  const auto value = [](const JsonPlace& from, const std::string& key, double unit = 1) {
    return fit::Estimate{number_at(from, key) * unit, number_at(from, key + "_sd") * unit};
  };
  for (const char* key :
       {"alpha_rad", "v_mm_s", "amplitude_mm", "amplitude_y_mm", "angular_frequency_rad_s", "phase_shift_rad",
        "phase_at_zero_rad", "angular_frequency_drift_rad_s2", "phi_rad", "dtau_rad"})
    if (const fit::Estimate seen = value(m, key); !std::isnan(seen.value)) run.measured[key] = seen;
  run.cycles = m.integer("cycles", 0);
  if (const auto gate = m.find("gate")) run.gate_source = gate->text("source");
  for (const JsonPlace& h : m.items("harmonics"))
    if (h.boolean("seen", false))
      run.harmonics.push_back(
          {h.integer("order", 0), value(h, "amplitude_mm", 1e-3), value(h, "amplitude_y_mm", 1e-3)});
}

/// run.track, its picture and what is drawn from both.
void add_track(const RunFolder& folder, ReportRun& run, ReportData& data) {
  const Track& track = run.track;
  run.sigma_px = median_of_finite(track.sigma_px);
  run.sigma_theta_rad = median_of_finite(track.sigma_theta_rad);
  if (track.in_camera_frame && !run.free_slide)
    run.notes.push_back("measured in the camera's frame: no marker");
  run.notes.insert(run.notes.end(), track.warnings.begin(), track.warnings.end());
  if (std::ifstream picture(folder.first_frame(run.name), std::ios::binary); picture)
    run.first_frame.assign(std::istreambuf_iterator<char>(picture), {});
  if (!run.free_slide) add_drawings(run);
  data.inputs.insert(data.inputs.end(), track.recorded_in.begin(), track.recorded_in.end());
}

/// What `run` left of its recording; notes what is missing.
void read_recording(const RunFolder& folder, ReportRun& run, ReportData& data) {
  const fs::path csv = folder.track(run.name), file = folder.measurement(run.name);
  Json measurement = Json::object();
  if (fs::exists(file))
    measurement = read_json(file);
  else if (!run.free_slide)
    note_missing(folder, run.name, file, "is missing: what was measured in it is not shown", data);
  reading(file, [&] { add_measurement({measurement, ""}, run); });
  if (!fs::exists(csv))
    return note_missing(folder, run.name, csv, "is missing: its path and platform are not shown", data);
  run.track = read_track_file(csv);
  reading(file, [&] {
    const JsonPlace m{measurement, ""};
    const double used = number_at(m, "mm_per_px");
    if (run.track.mm_per_px && std::isfinite(used) && used != *run.track.mm_per_px)
      rescale(run.track, {used, number_at(m, "mm_per_px_sd"), ""});
  });
  add_track(folder, run, data);
}

void add_run(const JsonPlace& configuration, const RunFolder& folder, ReportRun& run, ReportData& data) {
  run.video = configuration.text("video");
  if (run.video.empty()) run.video = configuration.text("track");
  if (!run.failure.empty()) return;
  if (const std::vector<std::string> lines = configuration.texts("pooled_from"); !lines.empty())
    run.notes.push_back(fmt::format("mean of {} measurements: {}", lines.size(), fmt::join(lines, ", ")));
  if (!run.video.empty()) return read_recording(folder, run, data);
  run.measured["alpha_rad"] = {number_at(configuration, "alpha_rad"),
                               number_at(configuration, "alpha_sd_rad")};
  run.measured["v_mm_s"] = {number_at(configuration, "v_mm_s"), number_at(configuration, "v_sd_mm_s")};
  run.cycles = configuration.integer("cycles", 0);
}

}  // namespace

std::vector<std::string> pooled_by_cause(const std::vector<std::string>& sentences,
                                         const std::vector<ReportRun>& runs) {
  struct Cause {
    std::string without_numbers, whole;
    std::vector<std::string> runs, sentences;
  };
  std::vector<Cause> causes;
  for (const std::string& whole : sentences) {
    std::string name, sentence = whole;
    for (const ReportRun& run : runs)
      for (const std::string& start : {run.name + ": ", "run " + run.name + ": "})
        if (sentence.starts_with(start)) {
          name = run.name;
          sentence.erase(0, start.size());
        }
    std::string key = name.empty() ? sentence : "";
    if (!name.empty())
      std::ranges::copy_if(sentence, std::back_inserter(key),
                           [](unsigned char c) { return !std::isdigit(c); });
    auto cause = std::ranges::find(causes, key, &Cause::without_numbers);
    if (cause == causes.end()) cause = causes.insert(causes.end(), {key, whole, {}, {}});
    if (!name.empty() && std::ranges::find(cause->runs, name) == cause->runs.end())
      cause->runs.push_back(name);
    if (std::ranges::find(cause->sentences, sentence) == cause->sentences.end())
      cause->sentences.push_back(sentence);
  }
  std::vector<std::string> lines;
  for (const Cause& cause : causes) {
    if (cause.runs.size() < 2) {
      lines.push_back(cause.whole);
      continue;
    }
    lines.push_back((cause.runs.size() == runs.size()
                         ? fmt::format("all {} runs: ", runs.size())
                         : fmt::format("runs {}: ", fmt::join(cause.runs, ", "))) +
                    cause.sentences.front());
    if (cause.sentences.size() > 1)
      lines.back() += fmt::format(" (in {}; in the others likewise)", cause.runs.front());
  }
  return lines;
}

ReportData collect(const RunFolder& folder, long most_steps) {
  if (fs::exists(folder.root) && !fs::is_directory(folder.root))
    throw InvalidInput("{}: is not a folder; name the one that `tribotrack run CAMPAIGN.toml -o DIR` filled",
                       folder.root.string());
  if (!fs::exists(folder.fit()))
    throw InvalidInput("{}: holds no fit.json; make one with `tribotrack run CAMPAIGN.toml -o {}`",
                       folder.root.string(), folder.root.string());
  const fs::path meta_file = folder.fit().string() + ".meta.json";
  if (!fs::exists(meta_file))
    throw InvalidInput(
        "{}: is missing, and with it the campaign's configuration; run it again: `tribotrack run "
        "CAMPAIGN.toml -o {}`",
        meta_file.string(), folder.root.string());
  const Json meta = read_json(meta_file);
  ReportData data;
  reading(folder.fit(), [&] { read_fit(read_json(folder.fit()), data); });
  reading(meta_file, [&] { read_meta(meta, meta_file, data); });
  for (std::size_t k = 0; k < data.runs.size(); ++k) {
    ReportRun& run = data.runs[k];
    reading(meta_file, [&] {
      add_run(JsonPlace{meta, ""}.at("configuration").at("runs").at(k), folder, run, data);
    });
    if (!run.fitted.name.empty() && !add_model_path(run))
      data.warnings.push_back(fmt::format(
          "run {}: the model's path is left out: the motion takes too many steps to follow", run.name));
  }
  std::set<std::string> days;
  for (const ReportRun& run : data.runs)
    if (run.track.recorded_at.size() >= 10) days.insert(run.track.recorded_at.substr(0, 10));  // "2021-03-04"
  if (!days.empty()) data.filmed = *days.begin() + (days.size() > 1 ? " to " + *days.rbegin() : "");
  add_curves(data, most_steps);
  data.warnings.insert(data.warnings.end(), data.missing.begin(), data.missing.end());
  data.warnings = pooled_by_cause(data.warnings, data.runs);
  return data;
}

}  // namespace tribotrack::apps
