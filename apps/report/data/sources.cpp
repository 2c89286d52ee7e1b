#include "apps/report/data/sources.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "apps/report/data/json.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

fs::path meta_of(const fs::path& result) {
  return result.string() + ".meta.json";
}

std::string file_name(const std::string& path) {
  return fs::path(path).filename().string();
}

/// A campaign by its file's name, or by its folder's where the file is just called campaign.toml.
std::string title_of(const fs::path& campaign) {
  const std::string folder = campaign.parent_path().filename().string();
  const bool plain = campaign.stem() == "campaign" && !folder.empty() && folder != "." && folder != "..";
  return plain ? folder : campaign.stem().string();
}

void add_given(const JsonPlace& configuration, ReportData& data) {
  const auto fitted = [&](const std::string& name) {
    return std::any_of(data.parameters.begin(), data.parameters.end(),
                       [&](const ReportParameter& p) { return p.name == name; });
  };
  for (const char* section : {"platform", "part"})
    if (const auto found = configuration.value.find(section); found != configuration.value.end())
      for (const auto& [name, value] : found->items())
        if (value.is_number() && !fitted(name)) data.given.push_back({name, value.get<double>(), "campaign"});
  const JsonPlace fixed = configuration.at("fit").at("fixed").object();
  for (const auto& item : fixed.value.items())
    data.given.push_back({item.key(), fixed.at(item.key()).number(), "campaign, held fixed"});
}

void add_inputs(const JsonPlace& meta, ReportData& data) {
  const JsonPlace inputs = meta.at("inputs").list();
  for (std::size_t k = 0; k < inputs.value.size(); ++k)
    data.inputs.push_back(
        {file_name(inputs.at(k).at("path").text()), "xxh3-128:" + text_at(inputs.at(k).value, "xxh3_128")});
}

/// The median; NaN where none is finite.
double median_of_finite(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return no_value;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void add_track_meta(const JsonPlace& meta, ReportRun& run) {
  const JsonPlace time_base = meta.at("time_base"), recording = meta.at("recording");
  run.frame_rate_hz = number_at(time_base.value, "rate_hz");
  run.time_base = text_at(time_base.value, "source");
  run.frame_width_px = recording.at("width").integer();
  run.frame_height_px = recording.at("height").integer();
  if (text_at(meta.value, "frame_of_reference") == "camera" && run.kind != "free_slide")
    run.notes.push_back("measured in the camera's frame: no marker");
  for (const std::string& note : sentences_at(meta.at("summary").value, "warnings"))
    run.notes.push_back(note);
  const JsonPlace plan = meta.at("plan").list();
  for (std::size_t k = 0; k < plan.value.size(); ++k) {
    const JsonPlace stage = plan.at(k);
    run.plan.push_back({text_at(stage.value, "stage"), stage.at("on").boolean(),
                        text_at(stage.value, "reason"), number_at(stage.value, "error_bound_px")});
  }
}

}  // namespace

void add_provenance(const Json& meta, ReportData& data) {
  const JsonPlace place{meta, ""};
  if (const int schema = place.at("schema").integer(); schema > kSchemaVersion)
    throw WrongContent(fmt::format("`schema` is {}, of a newer tribotrack; this one reads schema {}", schema,
                                   kSchemaVersion));
  const JsonPlace configuration = place.at("configuration");
  add_given(configuration, data);
  data.program_version = text_at(meta, "version");
  add_inputs(place, data);
  if (!data.inputs.empty()) data.title = title_of(place.at("inputs").at(0).at("path").text());
  data.configuration = configuration.value.dump(2, ' ', false, Json::error_handler_t::replace);
}

void add_track(const TrackFile& track, const RunFolder& folder, ReportRun& run) {
  run.x_px = track.x_px;
  run.y_px = track.y_px;
  run.x_mm = track.x_mm;
  run.y_mm = track.y_mm;
  run.frames_ok = track.frames - track.lost - track.edge;
  run.frames_lost = track.lost;
  run.frames_edge = track.edge;
  run.sigma_px = median_of_finite(track.sigma_px);
  if (track.meta.is_object())
    reading(meta_of(folder.track(run.name)), [&] { add_track_meta({track.meta, ""}, run); });
  if (std::ifstream picture(folder.first_frame(run.name), std::ios::binary); picture)
    run.first_frame.assign(std::istreambuf_iterator<char>(picture), {});
}

void add_recording(const TrackFile& track, const fs::path& csv, ReportData& data) {
  if (track.meta.is_object()) reading(meta_of(csv), [&] { add_inputs({track.meta, ""}, data); });
}

}  // namespace tribotrack::apps
