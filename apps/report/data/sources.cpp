#include "apps/report/data/sources.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "apps/report/data/json.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

std::string file_name(const std::string& path) {
  return fs::path(path).filename().string();
}

/// A campaign by its file's name, or by its folder's where the file is just called campaign.toml.
std::string title_of(const fs::path& campaign) {
  const std::string folder = campaign.parent_path().filename().string();
  const bool plain = campaign.stem() == "campaign" && !folder.empty() && folder != "." && folder != "..";
  return plain ? folder : campaign.stem().string();
}

bool is_sd(const std::string& name) {
  return name.ends_with("_sd") || name == "diameter_sd_mm";
}

/// With its sd where one was given; else the fit takes it as exact.
std::string source_of_given(const JsonPlace& section, const std::string& name) {
  const double sd = number_at(section, name == "diameter_mm" ? "diameter_sd_mm" : name + "_sd");
  return sd > 0 ? fmt::format("campaign, sd {:.3g}", sd) : "campaign, taken as exact";
}

void add_given(const JsonPlace& configuration, ReportData& data) {
  const auto fitted = [&](const std::string& name) {
    return std::any_of(data.parameters.begin(), data.parameters.end(),
                       [&](const ReportParameter& p) { return p.name == name; });
  };
  for (const char* section : {"platform", "part"})
    if (const auto found = configuration.find(section))
      for (const auto& [name, value] : found->object().value.items())
        if (value.is_number() && !fitted(name) && !is_sd(name))
          data.given.push_back({name, value.get<double>(), source_of_given(*found, name)});
  const JsonPlace fixed = configuration.at("fit").at("fixed").object();
  for (const auto& item : fixed.value.items())
    data.given.push_back({item.key(), fixed.at(item.key()).number(), "campaign, held fixed"});
}

ReportSource source_of(const std::string& path, const std::string& xxh3_128, const std::string& hashed) {
  return {file_name(path), "xxh3-128:" + xxh3_128 + (hashed.empty() ? "" : ", " + hashed)};
}

/// The median; NaN where none is finite.
double median_of_finite(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return no_value;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// "2021-03-04", or the first and the last day.
void add_day(const std::string& time, ReportData& data) {
  constexpr std::size_t kDay = 10;  // "2021-03-04"
  if (time.size() < kDay) return;
  const std::string day = time.substr(0, kDay), to = " to ";
  const auto at = data.filmed.find(to);
  std::string first = data.filmed.substr(0, kDay),
              last = at == std::string::npos ? first : data.filmed.substr(at + to.size());
  if (data.filmed.empty()) first = last = day;
  first = std::min(first, day);
  last = std::max(last, day);
  data.filmed = first == last ? first : first + to + last;
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

}  // namespace

void add_provenance(const Json& meta, ReportData& data) {
  const JsonPlace place{meta, ""};
  const JsonPlace configuration = place.at("configuration");
  add_given(configuration, data);
  data.program_version = place.text("version");
  data.part = part_text(configuration);
  const JsonPlace inputs = place.at("inputs").list();
  for (std::size_t k = 0; k < inputs.value.size(); ++k)
    data.inputs.push_back(source_of(inputs.at(k).at("path").text(), inputs.at(k).at("xxh3_128").text(),
                                    inputs.at(k).text("hashed")));
  if (!data.inputs.empty()) data.title = title_of(inputs.at(0).at("path").text());
  if (const std::string title = configuration.text("title"); !title.empty()) data.title = title;
  data.configuration = configuration.value.dump(2, ' ', false, Json::error_handler_t::replace);
}

void add_track(const TrackFile& track, const RunFolder& folder, ReportRun& run) {
  run.x_px = track.x_px;
  run.y_px = track.y_px;
  run.x_mm = track.x_mm;
  run.y_mm = track.y_mm;
  run.time_s = track.time_s;
  run.sigma_all_px = track.sigma_px;
  run.ncc = track.ncc;
  run.in_camera_frame = track.facts.in_camera_frame;
  run.theta_rad = track.theta_rad;
  run.sigma_theta_rad = median_of_finite(track.sigma_theta_rad);
  run.frames_ok = track.frames - track.lost - track.edge;
  run.frames_lost = track.lost;
  run.frames_edge = track.edge;
  run.sigma_px = median_of_finite(track.sigma_px);
  const TrackFacts& facts = track.facts;
  run.frame_rate_hz = facts.frame_rate_hz.value_or(no_value);
  run.time_base = facts.time_base;
  run.frame_width_px = facts.width_px;
  run.frame_height_px = facts.height_px;
  if (facts.in_camera_frame && run.kind != "free_slide")
    run.notes.push_back("measured in the camera's frame: no marker");
  run.notes.insert(run.notes.end(), facts.warnings.begin(), facts.warnings.end());
  run.audit = facts.audit;
  for (const PlannedStage& stage : facts.plan)
    run.plan.push_back({stage.stage, stage.on, stage.reason, stage.error_bound_px.value_or(no_value)});
  if (std::ifstream picture(folder.first_frame(run.name), std::ios::binary); picture)
    run.first_frame.assign(std::istreambuf_iterator<char>(picture), {});
}

void add_pooled_note(const std::vector<std::string>& lines, ReportRun& run) {
  if (!lines.empty())
    run.notes.push_back(fmt::format("mean of {} measurements: {}", lines.size(), fmt::join(lines, ", ")));
}

void add_recording(const TrackFile& track, ReportData& data) {
  add_day(track.facts.recorded_at, data);
  for (const Input& input : track.facts.recorded_in)
    data.inputs.push_back(source_of(input.path.string(), input.xxh3_128, input.hashed));
}

}  // namespace tribotrack::apps
