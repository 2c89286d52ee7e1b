// tribotrack probe: what a recording is, where its frame rate comes from, and what lies in it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "apps/commands/command.h"
#include "apps/files/run_folder.h"
#include "apps/files/traces/scope_file.h"
#include "apps/measuring/measure_track.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/survey/campaign_draft.h"
#include "apps/survey/survey_text.h"
#include "apps/text/input_file.h"
#include "apps/text/json.h"
#include "apps/text/output_file.h"
#include "vision/duplicate_frames.h"
#include "vision/frame_source.h"
#include "vision/overlay.h"
#include "vision/track.h"

namespace tribotrack::apps {

namespace {

struct ProbeOptions {
  std::string video, picture, page;
  std::optional<double> fps;
  bool json = false;
};

/// Frames are compared until so many pixels have been: a second or two.
constexpr double kPixelsToCompare = 3e8;

std::vector<std::int64_t> images(const vision::RepeatedFrames& repeats, const vision::SourceInfo& info) {
  std::vector<std::int64_t> numbers = repeats.repeated;
  for (std::int64_t& number : numbers) number += info.first_number;
  return numbers;
}

Json repeats_json(const vision::RepeatedFrames& repeats, const vision::SourceInfo& info) {
  Json still = Json::array();
  for (const auto& [first, last] : repeats.still)
    still.push_back(Json::array({info.first_number + first, info.first_number + last}));
  return {{"frames_compared", repeats.looked_at},
          {"repeated_images", images(repeats, info)},
          {"still_images", still}};
}

constexpr double kContrast = 100;  ///< grey levels of 255, for the forecast

double contrast_for(const vision::SourceInfo& info) {
  return std::ldexp(kContrast, info.bits - 8);
}

/// null for a recording that no lossy coder made.
Json coding_json(const vision::SourceInfo& info) {
  if (!info.coder) return {};
  const vision::Coder& coder = *info.coder;
  Json json = {{"coder", coder.name},
               {"settings", coder.settings},
               {"known", coder.known},
               {"grid_px", coder.grid},
               {"all_intra", coder.all_intra},
               {"frames_per_group", coder.group},
               {"step_levels", coder.step > 0 ? Json(coder.step) : Json()}};
  if (const auto expected = vision::forecast(coder, contrast_for(info))) {
    json["expected_error_px"] = expected->error_px;
    json["slow_motion_late_px"] = expected->late_px;
    json["advice"] = expected->advice;
  }
  return json;
}

Json description_of(const vision::SourceInfo& info, const vision::RepeatedFrames& repeats) {
  Json json = {{"path", info.path.string()},
               {"format", info.format},
               {"codec", info.codec},
               {"width_px", info.width},
               {"height_px", info.height},
               {"bits", info.bits},
               {"colour", info.colour},
               {"frames", info.frame_count},
               {"first_image", info.first_number},
               {"last_image", info.first_number + info.frame_count - 1},
               {"exposure_s", optional_json(info.exposure_s)},
               {"exposure_varies", !info.exposures_s.empty()},
               {"black_level", optional_json(info.black_level)},
               {"white_level", optional_json(info.white_level)},
               {"camera", info.camera},
               {"trigger_time", info.trigger_time},
               {"time_base", json_of(info, images(repeats, info), repeats.weaved)}};
  if (info.time_base.known() && info.frame_count > 0)
    json["last_time_s"] = info.time_base.time_s(info.frame_count - 1);
  if (!info.time_base.known()) json["time_base"]["why_unknown"] = info.time_base.why_unknown();
  json["repeats"] = repeats_json(repeats, info);
  json["coding"] = coding_json(info);
  json["notes"] = info.notes;
  return json;
}

void print_description(const vision::SourceInfo& info, const vision::RepeatedFrames& repeats) {
  print("{}\n  {} ({}), {} x {} pixels, {} bits{}\n", info.path.string(), info.format, info.codec, info.width,
        info.height, info.bits, info.colour ? ", colour" : "");
  print("  {} frames, image numbers {} to {}\n", info.frame_count, info.first_number,
        info.first_number + info.frame_count - 1);
  if (info.coder) print_text(measurement_text(coding_json(info), "  coding"));
  if (info.time_base.known())
    print("  recorded at {:.10g} frames/s, from: {}{}\n", *info.time_base.rate_hz, info.time_base.source,
          info.time_base.stamps_s.empty() ? "" : " (every frame has the time of its own stamp)");
  else
    print("  recorded at an unknown rate: {}\n  tracking needs --fps (frame_rate_hz in a campaign)\n",
          info.time_base.why_unknown());
  for (const auto& candidate : info.time_base.candidates)
    print("    {} {:.10g} frames/s by {}: {}\n", candidate.accepted ? "taken   " : "rejected",
          candidate.rate_hz, candidate.source, candidate.reason);
  if (!info.exposures_s.empty())
    print("  exposure {:.6g} to {:.6g} s\n", std::ranges::min(info.exposures_s),
          std::ranges::max(info.exposures_s));
  else if (info.exposure_s)
    print("  exposure {:.6g} s\n", *info.exposure_s);
  if (info.black_level && info.white_level)
    print("  black at level {}, white at {}\n", *info.black_level, *info.white_level);
  if (info.pixel_aspect != 1)
    print("  pixels {:.6g} times as wide as high: to be made square before tracking\n", info.pixel_aspect);
  if (!info.camera.empty()) print("  camera {}\n", info.camera);
  if (!info.trigger_time.empty()) print("  triggered {}\n", info.trigger_time);
  if (info.frame_count == 1) print("  note: one frame shows no motion: there is nothing to track\n");
  for (const auto& note : info.notes) print("  note: {}\n", note);
  if (repeats.looked_at < info.frame_count)
    print("  the first {} frames were compared with the one before each\n", repeats.looked_at);
}

/// What the first frame shows, in a picture, on a page and in JSON; nothing where none of them is asked for.
std::optional<vision::Survey> look_around(vision::FrameSource& source, const ProbeOptions& options) {
  const bool must = !options.picture.empty() || !options.page.empty();
  if (!must && !options.json) return std::nullopt;
  vision::Survey seen;
  try {
    seen = vision::survey(source);
  } catch (const vision::InputError&) {
    if (must) throw;
    return std::nullopt;  // the description says which frames cannot be read
  }
  if (!options.picture.empty()) {
    const auto png = vision::survey_png(source, seen);
    write_file(options.picture, {reinterpret_cast<const char*>(png.data()), png.size()}, Content::pictures);
  }
  if (!options.page.empty()) write_file(options.page, survey_page(source, seen));
  return seen;
}

void print_survey(const vision::Survey& seen, const vision::SourceInfo& info) {
  print("  in frame {}\n", seen.frame);
  for (const std::string& line : descriptions(seen)) print("    {}\n", line);
  print("  for the campaign, or a run of it\n{}", camera_section(seen, info));
}

/// What an oscilloscope's file holds.
Json trace_json(const ScopeFile& trace) {
  Json json = {{"path", trace.input.path.string()},
               {"format", "oscilloscope trace"},
               {"layout", trace.layout},
               {"samples", trace.channels.front().size()},
               {"start_s", trace.start_s},
               {"increment_s", trace.increment_s},
               {"channels", Json::array()}};
  for (std::size_t k = 0; k < trace.channels.size(); ++k) {
    const auto [least, most] = std::ranges::minmax(trace.channels[k]);
    json["channels"].push_back({{"name", trace.names[k]}, {"min_v", least}, {"max_v", most}});
  }
  return json;
}

void probe(const ProbeOptions& options) {
  if (may_be_trace(options.video)) {
    if (!options.picture.empty() || !options.page.empty())
      throw UsageError("--picture and --page belong to recordings: a trace has no frames");
    const Json json = trace_json(read_scope_file(options.video));
    print_text(options.json ? text_of(json) : measurement_text(json));
    return;
  }
  std::vector<Output> outputs;
  if (!options.picture.empty()) outputs.push_back({options.picture, Content::pictures});
  if (!options.page.empty()) outputs.push_back({options.page});
  require_writable(outputs, files_of_input(options.video));
  const auto source = vision::open_source(options.video, {options.fps});
  vision::SourceInfo info = source->info();
  const double pixels = static_cast<double>(info.width) * info.height;
  vision::RepeatedFrames repeats;
  try {
    repeats = vision::find_repeated_frames(*source, static_cast<std::int64_t>(kPixelsToCompare / pixels) + 2);
  } catch (const vision::InputError& error) {
    info.notes.push_back(std::string("not every frame can be read: ") + error.what());
  }
  for (std::string& finding : vision::findings(repeats, *source)) info.notes.push_back(std::move(finding));
  const auto seen = look_around(*source, options);
  if (options.json) {
    Json json = description_of(info, repeats);
    if (seen) json["survey"] = json_of(*seen);
    print_text(text_of(json));
    return;
  }
  print_description(info, repeats);
  if (seen) print_survey(*seen, info);
}

}  // namespace

void add_probe(CLI::App& app, Context& context) {
  auto options = std::make_shared<ProbeOptions>();
  CLI::App& command = *app.add_subcommand(
      "probe",
      "Describe a recording: size, depth, frames, where its frame rate comes from, and what lies in it; or "
      "an oscilloscope's trace: layout, sampling and channels");
  command.add_option("VIDEO", options->video, "The recording, or the trace (.csv, .txt)")->required();
  add_number(command, "--fps", options->fps, "Override the frame rate, to see what follows from it");
  add_option(command, "--picture", options->picture, "F.png",
             "Write the first frame with a pixel grid, its discs numbered, LEDs marked, and print the lines "
             "of [camera] to paste");
  add_option(
      command, "--page", options->page, "F.html",
      "Write a page to point at part, mark and gate LED with the mouse: frames to scrub, lines to copy");
  command.add_flag("--json", options->json, "Print one JSON object");
  add_common(command, context,
             "  tribotrack probe phi000.cine --picture first.png\n  tribotrack probe trace.csv");
  command.callback([options] { probe(*options); });
}

// tribotrack init: a commented campaign to start from, filled in from recordings where there are some.

namespace fs = std::filesystem;

namespace {

struct InitOptions {
  DraftOptions draft;
  std::string from, list;
  bool json = false;
};

CampaignDraft draft_for(const InitOptions& options, const Context& context) {
  if (options.from.empty()) {
    CampaignDraft empty;
    take_given(options.draft, empty);
    return empty;
  }
  if (!options.list.empty())
    return draft_of(read_run_list(options.list, read_text(options.list)), options.from, options.draft,
                    context);
  const std::vector<fs::path> recordings = recordings_in(options.from);
  if (recordings.empty())
    throw InvalidInput(
        "{}: holds no recording (.cine, video, TIFF stack or folders of pictures); give the folder that does",
        options.from);
  return draft_of(recordings, options.draft, context);
}

void init(const InitOptions& options, const Context& context) {
  const fs::path& folder = options.draft.folder;
  const fs::path file = folder / "campaign.toml";
  if (fs::exists(file))
    throw InvalidInput("{}: exists already and is not overwritten; give another folder", file.string());
  const CampaignDraft draft = draft_for(options, context);
  create_folder(folder);
  write_campaign(file, toml_of(draft));
  if (options.json)
    print_text(text_of(Json{{"campaign", file.string()},
                            {"runs", draft.runs.size()},
                            {"to_fill_in", draft.missing},
                            {"left_out", draft.left_out}}));
  else
    print("{}\n", file.string());
  for (const std::string& left_out : draft.left_out) complain(fmt::format("left out: {}", left_out));
  if (!options.from.empty())
    say(context.quiet, fmt::format("{} recordings; every guess is marked as one", draft.runs.size()));
  for (const std::string& missing : draft.missing) say(context.quiet, fmt::format("to fill in: {}", missing));
  say(context.quiet,
      fmt::format("{}: tribotrack run {} -o {}", draft.runs.empty() ? "add the recordings, then" : "then",
                  file.string(), (folder / "out").string()));
}

}  // namespace

void add_init(CLI::App& app, Context& context) {
  auto options = std::make_shared<InitOptions>();
  CLI::App& command = *app.add_subcommand("init", "Write a commented campaign to start from");
  add_option(command, "DIR", options->draft.folder, "DIR",
             "Folder to write campaign.toml into; made if it is not there")
      ->required();
  add_option(command, "--from", options->from, "RECORDINGS",
             "Inspect every recording of this folder: one [[run]] each, with part, mark and gate LED found, "
             "phi and dtau by the name (phi045_dtau060, 45deg_60deg)");
  add_option(command, "--list", options->list, "RUNS.csv",
             "A table that says of each recording what its name does not: columns video, phi_deg, dtau_deg "
             "(or _rad, or the unit in the cells), name, cycles, or any other key of a run; separated by , ; "
             "or tabs, decimal commas too")
      ->needs(command.get_option("--from"));
  add_number(command, "--disc-diameter-mm", options->draft.diameter_mm,
             "The part's diameter, which sets the scale");
  add_number(command, "--chamfer-mm", options->draft.chamfer_mm,
             "Width of the part's chamfer seen from above, 0 for a sharp edge");
  add_number(command, "--fps", options->draft.fps, "Frame rate, where the recordings do not say it");
  command.add_flag("--json", options->json, "Print what was found as one JSON object");
  add_common(command, context,
             "  tribotrack init my_campaign --from recordings --disc-diameter-mm 6\n"
             "  tribotrack init my_campaign --from recordings --list runs.csv --disc-diameter-mm 6");
  command.callback([options, &context] { init(*options, context); });
}

}  // namespace tribotrack::apps
