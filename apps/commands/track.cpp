// tribotrack track: a recording to a sub-pixel trajectory.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "apps/commands/command.h"
#include "apps/files/camera.h"
#include "apps/files/campaign/campaign.h"
#include "apps/files/run_folder.h"
#include "apps/files/tracks/any_track.h"
#include "apps/measuring/measure_track.h"
#include "apps/pipeline/line.h"
#include "apps/program/called.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/recording/recording.h"
#include "apps/recording/track.h"
#include "apps/text/angle.h"
#include "apps/text/output_file.h"
#include "vision/overlay.h"

namespace tribotrack::apps {

namespace {

struct TrackCommandOptions {
  std::string input, output, overlay, first_frame, debug;
  std::string campaign, run;                             ///< instead of an input and its choices
  std::map<std::string, std::optional<double>> numbers;  ///< of kTrackNumbers, by their flags
  TrackChoices choices;                                  ///< but for these
  bool json = false;
  bool explain = false;
};

std::vector<double> numbers_of(const std::string& flag, const std::string& text, std::size_t count,
                               const char* form) {
  std::vector<double> values;
  for (const std::string& part : parts_of(text, ','))
    if (const auto value = parse_number(part)) values.push_back(*value);
  if (values.size() != count || parts_of(text, ',').size() != count)
    throw UsageError("{} must read {}, not \"{}\"", flag, form, text);
  return values;
}

constexpr const char* kCircle = "X,Y,R in pixels, such as 640,400,150";

std::vector<std::int64_t> rectangle_of(const std::string& text) {
  const auto v = numbers_of("--template", text, 4, "X,Y,W,H in whole pixels, such as 100,40,41,41");
  for (const double value : v)
    if (value != std::floor(value)) throw UsageError("--template must be whole pixels");
  return {v.begin(), v.end()};
}

std::int64_t frame_number(const std::string& flag, const std::string& text) {
  const auto value = parse_number(text);
  if (!value || *value != std::floor(*value))
    throw UsageError("{} must hold the recording's own image numbers, not \"{}\"", flag, text);
  return static_cast<std::int64_t>(*value);
}

void set_frames(TrackChoices& choices, const std::string& text) {
  const auto parts = parts_of(text, ':');
  if (parts.size() != 2 && parts.size() != 3)
    throw UsageError(
        "--frames must read A:B or A:B:STEP in the recording's own image numbers (each may be empty), not "
        "\"{}\"",
        text);
  const auto number = [&](std::size_t k) {
    const bool there = k < parts.size() && !parts[k].empty();
    return there ? std::optional(frame_number("--frames", parts[k])) : std::nullopt;
  };
  choices.first_frame = number(0);
  choices.last_frame = number(1);
  choices.frame_step = number(2);
}

void set_marker(Json& camera, const std::string& text) {
  if (text == "auto" || text == "texture" || text == "none" || text.starts_with("tag:"))
    camera["marker"] = text;
  else
    camera["marker_px"] =
        numbers_of("--marker", text, 3, fmt::format("{}, or be {}", kCircle, kMarkerWords).c_str());
}

Recording recording_of(const TrackCommandOptions& options) {
  if (options.input == "-" || options.input == "/dev/stdin")
    throw InvalidInput("'{}': a recording is not read from standard input; give its file", options.input);
  TrackChoices choices = options.choices;
  for (const TrackFlag& flag : kTrackNumbers)
    if (const auto& value = options.numbers.at(flag.flag)) choices.keys[flag.section][flag.key] = *value;
  return recording_of(options.input, choices);
}

/// Refuses the folder the recording's own pictures lie in: the debug pictures would become part of it.
void check_debug_folder(const std::filesystem::path& folder, const std::filesystem::path& input) {
  const std::filesystem::path pictures = vision::is_number_pattern(input) ? input.parent_path() / "." : input;
  std::error_code ignored;
  if (std::filesystem::is_directory(pictures) && std::filesystem::equivalent(folder, pictures, ignored))
    throw InvalidInput("{}: the recording's own pictures lie there; give --debug another folder",
                       folder.string());
}

void print_explanation(const vision::TrackResult& result) {
  for (const auto& stage : result.summary.plan)
    print_error(fmt::format("{:<24} {:<4} {}", stage.name, stage.on ? "on" : "off", stage.reason));
  print_error(measurement_text(json_of(result.summary.audit), "audit"));
  double total = 0;
  for (const auto& stage : result.stage_times) total += stage.seconds;
  print_error(fmt::format("{:<30} {:>9} {:>6}", "time of each stage", "s", "share"));
  for (const auto& stage : result.stage_times)
    print_error(
        fmt::format("  {:<28} {:>9.4f} {:>4.0f} %", stage.name, stage.seconds, 100 * stage.seconds / total));
}

void check_outputs(const TrackCommandOptions& options, const std::vector<std::filesystem::path>& inputs) {
  std::vector<Output> outputs;
  if (!options.output.empty() && !is_printed(options.output, options.json))
    outputs.push_back({options.output});
  for (const std::string& pictures : {options.overlay, options.first_frame})
    if (!pictures.empty()) outputs.push_back({pictures, Content::pictures});
  require_writable(outputs, inputs);
  if (!options.overlay.empty()) vision::require_overlay_name(options.overlay);
}

std::vector<std::filesystem::path> inputs_of(const TrackCommandOptions& options, bool in_memory) {
  std::vector<std::filesystem::path> inputs;
  if (!in_memory) inputs = files_of_input(options.input);
  for (const std::string& file : {options.choices.config, options.choices.calibration})
    if (!file.empty()) inputs.emplace_back(file);
  return inputs;
}

/// To the caller: the table column by column, and what stands in its meta file.
void hand_over(const Recording& recording, Called& called) {
  called.columns = columns_of(recording.rows);
  called.object["meta"] = meta_of(recording).json();
  called.object["meta"]["result_xxh3_128"] = hash_of_text(track_csv(recording.rows));  // as write_result()
}

/// Tracks, writes what was asked for, and says how it went.
void track_and_write(const TrackCommandOptions& options, Recording recording, Context& context) {
  std::optional<Progress> progress(std::in_place, "track", context, "frames");
  recording.options.progress = [&](std::int64_t done, std::int64_t total) { progress->update(done, total); };
  recording = apps::tracked(std::move(recording), options.output.empty()
                                                      ? std::nullopt
                                                      : std::optional<std::filesystem::path>(options.output));
  progress.reset();
  if (!options.first_frame.empty()) write_first_frame(options.first_frame, recording);
  if (!options.overlay.empty()) write_overlay_file(options.overlay, recording);
  if (!options.output.empty()) write_track(options.output, recording);
  if (context.called) hand_over(recording, *context.called);

  const vision::TrackSummary& summary = recording.result.summary;
  if (options.explain) print_explanation(recording.result);
  for (const auto& note : recording.info().notes) say(context.quiet, "note: " + note);
  if (!recording.scale)
    say(context.quiet,
        "note: no scale was given: the millimetre columns are empty (--mm-per-px, --disc-diameter-mm, "
        "--tag-mm or --calibration)");
  for (const auto& warning : summary.warnings) say(context.quiet, "warning: " + warning);
  say(context.quiet, summary.brief_report());
  if (options.json) print_text(text_of(summary_json(recording)));
  if (const std::string failure = gate_failure(recording); !failure.empty())
    context.doubt(kQualityGate, failure);
}

/// As `run` does it: the bytes of the track are the same, unless --frames asks for some only.
void track_run(const TrackCommandOptions& options, Context& context) {
  if (options.run.empty()) throw CLI::RequiredError("--run NAME");
  if (is_standard_output(options.output))
    throw UsageError("the track of a campaign's run is a file: give -o T.csv");
  const Campaign campaign = campaign_of_part(read_campaign(campaign_file(options.campaign)), "");
  CampaignRun run = run_named(campaign, options.run);
  if (options.choices.first_frame) run.first_frame = options.choices.first_frame;
  if (options.choices.last_frame) run.last_frame = options.choices.last_frame;
  run.frame_step = options.choices.frame_step.value_or(run.frame_step);
  // Not those of the campaign's other runs: a campaign has a job for each, and each would look at all.
  check_outputs(options, campaign.input_files({run}));
  leaving_word(run, options.output, [&] {
    if (!run.video) {
      import_track(*run.track, run.reading, options.output);
      return;
    }
    Recording recording = checked_recording(campaign, run);
    recording.options.threads = threads_to_use(context);
    track_and_write(options, std::move(recording), context);
  });
}

void track_command(const TrackCommandOptions& options, Context& context) {
  if (options.output.empty() && !context.called) throw UsageError("the output file has no name");
  if (!options.campaign.empty()) return track_run(options, context);
  if (options.input.empty()) throw CLI::RequiredError("INPUT, or --campaign with --run,");
  Recording recording = recording_of(options);
  if (context.called && context.called->frames) {
    if (!recording.camera.frame_rate_hz) throw UsageError("frames in memory have no frame rate: give --fps");
    recording.source = context.called->frames(*recording.camera.frame_rate_hz);
  }
  check_outputs(options, inputs_of(options, recording.source != nullptr));
  recording.options.threads = threads_to_use(context);

  std::optional<vision::DebugFolder> debug;
  if (!options.debug.empty()) {
    check_debug_folder(options.debug, options.input);
    debug.emplace(options.debug);
    recording.options.debug = &*debug;
  }
  track_and_write(options, checked(std::move(recording)), context);
}

/// What only a recording named by itself can be told: a campaign says it for its runs.
void exclude_choices(CLI::App& command, CLI::Option& campaign) {
  for (const char* name :
       {"INPUT", "--fps", "--fps-reason", "--mm-per-px", "--tag-mm", "--disc-diameter-mm", "--chamfer-mm",
        "--calibration", "--height-mm", "--working-distance-mm", "--disc", "--template", "--marker", "--gate",
        "--xi-axis-rad", "--layers", "--debug", "--config"})
    campaign.excludes(command.get_option(name));
}

}  // namespace

void add_track(CLI::App& app, Context& context) {
  auto options = std::make_shared<TrackCommandOptions>();
  CLI::App& command = *app.add_subcommand("track", "Track the part in a recording to a sub-pixel trajectory");
  command.add_option(
      "INPUT", options->input,
      "Phantom .cine, a video, a multi-page TIFF, a folder of pictures, or a pattern dir/%05d.png");
  add_option(command, "-o,--output", options->output, "T.csv", "The track table")->required(!context.called);
  for (const TrackFlag& flag : kTrackNumbers) {
    const bool angle = std::string_view(flag.flag).ends_with("-rad");
    (angle ? add_angle : add_number)(command, flag.flag, options->numbers[flag.flag], flag.help);
  }
  Json& camera = options->choices.keys["camera"];
  const auto add = [&command](const char* flag, const char* type, auto take, const char* help) {
    command.add_option_function<std::string>(flag, take, help)->type_name(type);
  };
  add(
      "--fps-reason", "TEXT", [&camera](const std::string& text) { camera["frame_rate_reason"] = text; },
      "Source of the frame rate, for the meta file; required if --fps equals the file's playback rate");
  add_option(command, "--calibration", options->choices.calibration, "FILE",
             "Scale, lens and plane of the platform from `tribotrack calibrate`");
  add(
      "--disc", "X,Y,R",
      [&camera](const std::string& text) { camera["disc_px"] = numbers_of("--disc", text, 3, kCircle); },
      "The disc in the first analysed frame, or where it is first seen there (default: found; where several "
      "may be it, a picture numbers them)");
  add(
      "--template", "X,Y,W,H",
      [&camera](const std::string& text) { camera["template_px"] = rectangle_of(text); },
      "Follow this rectangle instead of a disc");
  add(
      "--marker", "X,Y,R|auto|texture|none|tag:FAMILY",
      [&camera](const std::string& text) { set_marker(camera, text); },
      "Mark fixed to the platform: its motion is subtracted. texture: the platform's own, all that is seen "
      "of it; auto: a round mark, else texture. Default: texture where it is seen to move, else none. "
      "tag:FAMILY[:NUMBER]: an ArUco or AprilTag mark, as tag:4x4_50 or tag:apriltag_36h11:3");
  add(
      "--gate", "X,Y,R",
      [&camera](const std::string& text) { camera["gate_px"] = numbers_of("--gate", text, 3, kCircle); },
      "LED that is on while the actuator is: its brightness is recorded, and `measure` finds phi and dtau "
      "from it");
  add(
      "--frames", "A:B[:STEP]",
      [&choices = options->choices](const std::string& text) { set_frames(choices, text); },
      "Image numbers of the first and last frame to analyse, both included; every n-th of them");
  add_option(command, "--layers", options->choices.layers, "auto|on|off",
             "Second pass with the appearance of disc and platform learned from the recording (default auto: "
             "for discs, kept where it does better)");
  add_option(command, "--overlay", options->overlay, "FILE",
             "Picture (.png) or video (.mp4) to check the track by");
  add_option(command, "--first-frame", options->first_frame, "FILE",
             "The first frame in which the part is seen, as a reduced picture (.jpg)");
  add_option(command, "--debug", options->debug, "DIR",
             "Write a picture of every stage (window, template, weights, prediction, residual; disc, share "
             "of the ground, and ground of the second pass) and index.txt into this folder: of the first, "
             "middle and last of the --frames, and of that with the largest residual");
  add_option(command, "--config", options->choices.config, "C.toml",
             "TOML with [camera], [part] as in a campaign and [track] min_ncc, max_lost_share");
  CLI::Option* campaign =
      add_option(command, "--campaign", options->campaign, "CAMPAIGN.toml",
                 "With --run: track the recording of one run of this campaign as `run` does, instead of an "
                 "INPUT; a recording that cannot be used says why in T.log, which `fit --tracks` repeats");
  add_option(command, "--run", options->run, "NAME", "Name of the run")->needs(campaign);
  exclude_choices(command, *campaign);
  command.add_flag("--json", options->json, "Print a summary as one JSON object");
  command.add_flag("--explain", options->explain, "Print which stages this scene needed and why");
  add_common(
      command, context,
      "  tribotrack track phi000.cine --disc-diameter-mm 6 --marker auto -o phi000.csv --overlay phi000.mp4\n"
      "  tribotrack track slide.mp4 --fps 240 --disc 151,87,9 --disc-diameter-mm 31 --frames 188: -o "
      "slide.csv\n"
      "  tribotrack track --campaign campaign.toml --run phi000 -o out/tracks/phi000.csv");
  command.callback([options, &context] { track_command(*options, context); });
}

}  // namespace tribotrack::apps
