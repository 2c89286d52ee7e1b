// tribotrack measure: alpha, v and whatever else one track shows.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "apps/commands/command.h"
#include "apps/files/camera.h"
#include "apps/files/run_folder.h"
#include "apps/files/tracks/any_track.h"
#include "apps/measuring/measure_text.h"
#include "apps/measuring/measure_track.h"
#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/angle.h"
#include "apps/text/number_text.h"
#include "apps/text/output_file.h"
#include "apps/usage/wrong_usage.h"

namespace tribotrack::apps {

namespace {

struct MeasureOptions {
  std::string track, output;
  MeasureChoices choices;
  TrackReading reading;  ///< of another program's track
  bool json = false;
};

void check_output(const MeasureOptions& options) {
  if (options.output.empty()) return;
  if (is_standard_output(options.output)) {
    if (options.json) throw UsageError("give -o - or --json: both would go to standard output");
    return;
  }
  require_writable({{options.output}}, {options.track, options.track + ".meta.json"});
}

void measure_command(const MeasureOptions& options, Context& context) {
  check_output(options);
  const TrackReading& reading = options.reading;
  for (const auto& [flag, value] :
       {std::pair{"--mm-per-px", reading.mm_per_px}, std::pair{"--fps", reading.frame_rate_hz}})
    if (value && !(*value > 0)) throw UsageError(fmt::format("{} must be greater than 0", flag));
  const Track track = read_any_track(options.track, reading);
  if (!track.imported.empty())
    for (const std::string& warning : track.warnings) say(context.quiet, "note: " + warning);
  const TrackMeasurement result = measure_track(options.track, track, options.choices);
  if (!options.output.empty()) {
    MetaFile meta;
    meta.command = "measure";
    meta.inputs = track.inputs;
    meta.configuration = result.configuration;
    write_result(options.output, text_of(result.json), meta);
  }
  if (!is_standard_output(options.output))
    print_text(options.json ? text_of(result.json) : measurement_text(result.json));
  for (const auto& warning : result.warnings) say(context.quiet, "warning: " + warning);
  if (result.failure.empty()) return;
  complain(result.failure);
  context.exit_code = kQualityGate;
}

}  // namespace

void add_measure(CLI::App& app, Context& context) {
  auto options = std::make_shared<MeasureOptions>();
  CLI::App& command = *app.add_subcommand(
      "measure",
      "Measure one track: its kind of motion; alpha, v and the platform's motion, or mu1 of a free slide");
  command
      .add_option(
          "TRACK", options->track,
          "A table written by `tribotrack track`, or a track of Tracker, Kinovea, DLTdv, trackpy or another "
          "program (t_s,x_mm,y_mm)")
      ->type_name("T.csv")
      ->required();
  add_number(command, "--omega-rad-s,--angular-frequency-rad-s", options->choices.omega_rad_s,
             "Angular frequency of the platform, where no marker shows it");
  add_angle(command, "--epsilon-rad,--phase-shift-rad", options->choices.epsilon_rad,
            "Phase shift the platform should have: its sense is checked");
  add_number(command, "--cycles", options->choices.cycles,
             "Whole cycles to measure over, at most (default 20)");
  command.add_flag("--free-slide", options->choices.free_slide,
                   "The platform rests and the part slides: mu1, deceleration, stop and spin (also without "
                   "this flag where "
                   "no drive is given or seen); exit 4 where the track shows another motion");
  add_number(command, "--gravity-m-s2", options->choices.gravity_m_s2,
             "Of a free slide: mu1 = deceleration / g (default 9.81)");
  add_number(command, "--mm-per-px", options->reading.mm_per_px,
             "Scale of another program's track that is in pixels");
  add_number(command, "--fps", options->reading.frame_rate_hz,
             "Rate at which the frames of another program's track were taken; overrides its times");
  command
      .add_option("--track-unit", options->reading.unit,
                  "Unit of x and y of another program's track whose columns name none")
      ->check(one_of({"px", "um", "mm", "cm", "m"}));
  command
      .add_option("--track-y", options->reading.y,
                  "Where its y points: up or down (default: down in pixels, up in lengths)")
      ->check(one_of({"up", "down"}));
  command
      .add_option(
          "--track-frame", options->reading.frame,
          "Its positions are relative to the platform or to the camera (default: camera without a mark)")
      ->check(one_of({"platform", "camera"}));
  command.add_option("--track-point", options->reading.point, "Which of its points is the part")
      ->type_name("NAME");
  command.add_option("--track-mark", options->reading.mark, "Which of its points is fixed to the platform")
      ->type_name("NAME");
  command.add_option("-o,--output", options->output, "Write the results as JSON")->type_name("M.json");
  command.add_flag("--json", options->json, "Print the results as one JSON object");
  add_common(
      command, context,
      "  tribotrack measure phi000.csv --json\n  tribotrack measure phi000.csv --omega-rad-s 62.8\n  "
      "tribotrack "
      "measure slide.csv --free-slide\n  tribotrack measure tracker.txt --omega-rad-s 62.8 --track-unit "
      "mm\n\n"
      "motion (first line; --json: motion, motion_sentence): driven, slide to rest, incline, swinging, "
      "pulled,\n"
      "at rest, with background, unknown. alpha and v belong to a drive that is given or seen, mu1 to a "
      "slide to\n"
      "rest with constant deceleration; if the track shows another motion: exit 4 and what to do instead.");
  command.callback([options, &context] { measure_command(*options, context); });
}

}  // namespace tribotrack::apps
