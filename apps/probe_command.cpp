// tribotrack probe: what a recording is, and where its frame rate comes from.
#include <fmt/format.h>

#include <memory>

#include "apps/command.h"
#include "apps/meta_file.h"
#include "vision/frame_source.h"

namespace tribotrack::apps {

namespace {

Json description_of(const vision::SourceInfo& info) {
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
               {"exposure_s", info.exposure_s ? Json(*info.exposure_s) : Json()},
               {"camera", info.camera},
               {"trigger_time", info.trigger_time},
               {"time_base", json_of(info.time_base)}};
  if (info.time_base.known() && info.frame_count > 0)
    json["last_time_s"] = info.time_base.time_s(info.frame_count - 1);
  if (!info.time_base.known()) json["time_base"]["why_unknown"] = info.time_base.why_unknown();
  json["notes"] = info.notes;
  return json;
}

void print(const vision::SourceInfo& info) {
  fmt::print("{}\n  {} ({}), {} x {} pixels, {} bits{}\n", info.path.string(), info.format, info.codec,
             info.width, info.height, info.bits, info.colour ? ", colour" : "");
  fmt::print("  {} frames, image numbers {} to {}\n", info.frame_count, info.first_number,
             info.first_number + info.frame_count - 1);
  if (info.time_base.known())
    fmt::print("  recorded at {} frames/s, from: {}{}\n", *info.time_base.rate_hz, info.time_base.source,
               info.time_base.stamps_s.empty() ? "" : " (every frame is stamped)");
  else
    fmt::print("  recorded at an unknown rate: {}\n  tracking needs --fps (frame_rate_hz in a campaign)\n",
               info.time_base.why_unknown());
  for (const auto& candidate : info.time_base.candidates)
    fmt::print("    {} {} frames/s by {}: {}\n", candidate.accepted ? "taken   " : "rejected",
               candidate.rate_hz, candidate.source, candidate.reason);
  if (info.exposure_s) fmt::print("  exposure {} s\n", *info.exposure_s);
  if (!info.camera.empty()) fmt::print("  camera {}\n", info.camera);
  if (!info.trigger_time.empty()) fmt::print("  triggered {}\n", info.trigger_time);
  for (const auto& note : info.notes) fmt::print("  note: {}\n", note);
}

}  // namespace

void add_probe(CLI::App& app, Context& context) {
  auto video = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  auto fps = std::make_shared<std::optional<double>>();
  CLI::App& command =
      *app.add_subcommand("probe", "Say what a recording is and where its frame rate comes from");
  command.add_option("VIDEO", *video, "The recording")->required();
  add_number(command, "--fps", *fps, "Your word on the frame rate, to see how it is taken");
  command.add_flag("--json", *json, "Print one JSON object");
  add_common(command, context, "  tribotrack probe phi000.cine");
  command.callback([video, json, fps] {
    const auto source = vision::open_source(*video, {*fps});
    if (*json)
      fmt::print("{}", text_of(description_of(source->info())));
    else
      print(source->info());
  });
}

}  // namespace tribotrack::apps
