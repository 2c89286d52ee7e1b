// tribotrack measure: alpha, v and whatever else one track shows.

#include <algorithm>
#include <cstdio>
#include <memory>
#include <numbers>

#include "apps/commands/command.h"
#include "apps/files/camera.h"
#include "apps/files/campaign/keys.h"
#include "apps/files/run_folder.h"
#include "apps/files/tracks/any_track.h"
#include "apps/measuring/measure_track.h"
#include "apps/program/called.h"
#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/simulating/simulation.h"
#include "apps/text/number_text.h"
#include "apps/text/output_file.h"
#include "apps/usage/wrong_usage.h"
#include "vision/calibration.h"

namespace tribotrack::apps {

namespace {

struct MeasureOptions {
  std::string track, output;
  MeasureChoices choices;
  DataSection data;  ///< how another program's track is read
  bool json = false;
};

/// A file's, or the one that the caller has in memory.
Track track_of(const MeasureOptions& options, const Context& context) {
  if (!context.called || context.called->input.is_null())
    return read_any_track(options.track, options.data.tracks);
  const Json& given = context.called->input;
  return track_of_text(options.track, given["csv"],
                       given.contains("meta") ? std::optional(given["meta"]) : std::nullopt);
}

void measure_command(const MeasureOptions& options, Context& context) {
  check_output(options.output, options.json, {options.track, options.track + ".meta.json"});
  const TrackReading& reading = options.data.tracks;
  for (const auto& [flag, value] :
       {std::pair{"--mm-per-px", reading.mm_per_px}, std::pair{"--fps", reading.frame_rate_hz}})
    if (value && !(*value > 0)) throw UsageError("{} must be greater than 0", flag);
  const Track track = track_of(options, context);
  if (!track.imported.empty())
    for (const std::string& warning : track.warnings) say(context.quiet, "note: " + warning);
  const TrackMeasurement result = measure_track(options.track, track, options.choices);
  if (context.called) {
    context.called->object = result.json;
  } else if (!options.output.empty()) {
    write_result(options.output, text_of(result.json), {"measure", track.inputs, result.configuration});
  }
  if (!is_standard_output(options.output) && !context.called)
    print_text(options.json ? text_of(result.json) : measurement_text(result.json));
  for (const auto& warning : result.warnings) say(context.quiet, "warning: " + warning);
  if (!result.failure.empty()) context.doubt(kQualityGate, result.failure);
}

}  // namespace

void add_measure(CLI::App& app, Context& context) {
  auto options = std::make_shared<MeasureOptions>();
  CLI::App& command = *app.add_subcommand(
      "measure",
      "Measure one track: its kind of motion; alpha, v and the platform's motion, or mu1 of a free slide");
  add_option(command, "TRACK", options->track, "T.csv",
             "A table written by `tribotrack track`, or a track of Tracker, Kinovea, DLTdv, trackpy or "
             "another program (t_s,x_mm,y_mm)")
      ->required();
  add_number(command, "--omega-rad-s,--angular-frequency-rad-s", options->choices.omega_rad_s,
             "Angular frequency of the platform, where no marker shows it");
  add_angle(command, "--epsilon-rad,--phase-shift-rad", options->choices.epsilon_rad,
            "Phase shift the platform should have: its sense is checked");
  add_option(command, "--cycles", options->choices.cycles, "N",
             "Whole cycles to measure over, at most (default 20)")
      ->check(whole_number(1, 1'000'000));
  command.add_flag("--free-slide", options->choices.free_slide,
                   "The platform rests and the part slides: mu1, deceleration, stop and spin (also without "
                   "this flag where no drive is given or seen); exit 4 where the track shows another motion");
  add_number(command, "--gravity-m-s2", options->choices.gravity_m_s2,
             "Of a free slide: mu1 = deceleration / g (default 9.81)");
  add_number(command, "--mm-per-px", options->data.tracks.mm_per_px,
             "Scale of another program's track that is in pixels");
  add_number(command, "--fps", options->data.tracks.frame_rate_hz,
             "Rate at which the frames of another program's track were taken; overrides its times");
  for (const Key<DataSection>& key : data_keys()) {  // as a campaign has them
    if (!key.name.starts_with("track_")) continue;
    auto* word = std::get<std::string*>(key.value(options->data).value());
    CLI::Option* option = command.add_option(flag_of(key.name), *word, key.meaning);
    if (!key.kind.words.empty()) option->check(one_of(key.kind.words));
  }
  add_option(command, "-o,--output", options->output, "M.json", "Write the results as JSON");
  command.add_flag("--json", options->json, "Print the results as one JSON object");
  add_common(
      command, context,
      "  tribotrack measure phi000.csv --json\n  tribotrack measure phi000.csv --omega-rad-s 62.8\n  "
      "tribotrack measure slide.csv --free-slide\n  tribotrack measure tracker.txt --omega-rad-s 62.8 "
      "--track-unit mm\n\n"
      "motion (first line; --json: motion, motion_sentence): driven, slide to rest, incline, swinging, "
      "pulled,\n"
      "at rest, with background, unknown. alpha and v belong to a drive that is given or seen, mu1 to a "
      "slide to\n"
      "rest whose deceleration is constant within the track's errors; else: exit 4 and what to do instead.");
  command.callback([options, &context] { measure_command(*options, context); });
}

// tribotrack calibrate: pictures of a checkerboard to the camera's lens, the platform's plane and its scale.

namespace {

struct CalibrateOptions {
  std::vector<std::string> inputs;
  std::string plane, squares, output;
  std::optional<double> square_mm, square_sd_mm;
  bool json = false;
};

vision::CalibrationBoard board_of(const CalibrateOptions& options) {
  vision::CalibrationBoard board;
  int read = 0;
  if (std::sscanf(options.squares.c_str(), "%dx%d%n", &board.columns, &board.rows, &read) != 2 ||
      static_cast<std::size_t>(read) != options.squares.size() || std::max(board.columns, board.rows) > 1000)
    throw UsageError("--squares must read COLUMNSxROWS, such as 10x7 (squares, not corners), not \"{}\"",
                     options.squares);
  if (!(*options.square_mm > 0))
    throw UsageError("--square-mm must be greater than 0, not {}", *options.square_mm);
  board.square_mm = *options.square_mm;
  board.square_relative_sd = options.square_sd_mm.value_or(0) / board.square_mm;
  try {
    board.validate();
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  return board;
}

void print_table(const vision::CalibrationResult& result) {
  const auto& c = result.calibration;
  print("{} x {} pixels, {} mm/px on the platform, {:.1f} mm from the lens's pupil\n", c.width, c.height,
        quoted(c.mm_per_px, c.mm_per_px_sd), c.distance_mm());
  print("focal length {:.1f} x {:.1f} px, sd {:.2g}, middle ({:.1f}, {:.1f}) px, lens terms: {}\n", c.lens.fx,
        c.lens.fy, result.focal_sd_px, c.lens.cx, c.lens.cy, result.model);
  print("reprojection rms {:.4f} px\n\n{:>8} {:>9} {:>9}  picture\n", result.rms_px, "corners", "rms px",
        "tilt deg");
  for (const auto& p : result.pictures)
    print("{:>8} {:>9.4f} {:>9.1f}  {}\n", p.corners, p.rms_px, p.tilt_rad * 180 / std::numbers::pi, p.name);
}

void calibrate_command(const CalibrateOptions& options, Context& context) {
  const vision::CalibrationBoard board = board_of(options);
  std::vector<std::filesystem::path> read;
  for (const std::string& input : options.inputs)
    for (const auto& file : files_of_input(input)) read.push_back(file);
  for (const auto& file : files_of_input(options.plane)) read.push_back(file);
  require_writable({{options.output}}, read);
  const vision::CalibrationPicture plane = vision::calibration_picture(options.plane);
  const std::vector<std::filesystem::path> inputs(options.inputs.begin(), options.inputs.end());
  const vision::CalibrationResult result =
      vision::calibrate_camera(board, plane, vision::calibration_pictures(inputs, plane));
  const Json json = calibration_json(result);
  MetaFile meta;
  meta.command = "calibrate";
  for (const auto& input : inputs) meta.inputs.push_back(hashed_recording(input));
  meta.inputs.push_back(hashed_recording(options.plane));
  meta.configuration = {{"squares", options.squares},
                        {"square_mm", board.square_mm},
                        {"square_relative_sd", board.square_relative_sd}};
  write_result(options.output, text_of(json), meta);
  for (const auto& left_out : result.left_out) say(context.quiet, "left out: " + left_out);
  if (options.json)
    print_text(text_of(json));
  else
    print_table(result);
}

}  // namespace

void add_calibrate(CLI::App& app, Context& context) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App& command = *app.add_subcommand(
      "calibrate", "Determine lens, plane of the platform and scale from pictures of a checkerboard");
  command
      .add_option("PICTURES", options->inputs,
                  "Pictures of the whole board, tilted by 15 to 45 degrees in several directions: files, "
                  "folders, patterns dir/%05d.png or videos")
      ->required();
  add_option(command, "--plane", options->plane, "PICTURE", "A picture of the board lying on the platform")
      ->required();
  add_option(command, "--squares", options->squares, "COLUMNSxROWS", "Squares of the board, not corners")
      ->required();
  add_number(command, "--square-mm", options->square_mm, "Side of a square");
  command.get_option("--square-mm")->required();
  add_number(command, "--square-sd-mm", options->square_sd_mm,
             "Standard deviation of that side: enters the sd of the scale");
  add_option(command, "-o,--output", options->output, "calibration.json", "The calibration")->required();
  command.add_flag("--json", options->json, "Print it as one JSON object");
  add_common(
      command, context,
      "  tribotrack calibrate board/*.png --plane flat.png --squares 10x7 --square-mm 2 -o calibration.json\n"
      "  tribotrack track phi000.cine --calibration calibration.json --height-mm 0.8 --marker auto -o t.csv");
  command.callback([options, &context] { calibrate_command(*options, context); });
}

}  // namespace tribotrack::apps
