// tribotrack measure: alpha, v and whatever else one track shows.
#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "apps/commands/command.h"
#include "apps/commands/wrong_usage.h"
#include "apps/files/meta_file.h"
#include "apps/files/tracks/any_track.h"
#include "apps/measuring/measure_run.h"
#include "apps/measuring/measure_slide.h"
#include "apps/measuring/measure_text.h"
#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace {

struct MeasureOptions {
  std::string track, output;
  std::optional<double> angular_frequency, phase_shift, cycles;
  std::optional<double> gravity;
  TrackReading reading;  ///< of another program's track
  std::string track_y;
  bool free_slide = false;
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

struct Printed {
  Json json;
  std::string text;
  std::vector<std::string> warnings;
};

void write_and_print(const MeasureOptions& options, const TrackFile& track, const Json& configuration,
                     const Printed& result, const Context& context) {
  if (!options.output.empty()) {
    MetaFile meta;
    meta.command = "measure";
    meta.inputs = track.inputs;
    meta.configuration = configuration;
    write_result(options.output, text_of(result.json), meta);
  }
  if (!is_standard_output(options.output)) print_text(options.json ? text_of(result.json) : result.text);
  for (const auto& warning : result.warnings) say(context.quiet, "warning: " + warning);
}

/// A part that slides on the resting platform: no drive is given, none is seen.
void measure_free_slide(const MeasureOptions& options, const TrackFile& track, const Context& context) {
  const double gravity = options.gravity.value_or(9.81);
  if (!(gravity > 0)) throw UsageError("--gravity-m-s2 must be greater than 0");
  std::optional<SlideMeasurement> m;
  try {
    m = measure_slide(options.track, track, gravity);
  } catch (const fit::DataError& no_slide) {
    if (options.free_slide) throw;
    throw InvalidInput(
        fmt::format("{}: the platform's frequency is neither given nor seen in the track, and it is no free "
                    "slide either ({}); "
                    "give --omega-rad-s, or track with --marker",
                    options.track, no_slide.what()));
  }
  write_and_print(options, track, {{"free_slide", true}, {"gravity_m_s2", gravity}},
                  {slide_measurement_json(*m, track), slide_measurement_text(*m, track), m->warnings},
                  context);
}

void measure_command(const MeasureOptions& options, Context& context) {
  check_output(options);
  TrackReading reading = options.reading;
  if (!options.track_y.empty())
    reading.y = options.track_y == "up" ? TrackReading::YAxis::up : TrackReading::YAxis::down;
  for (const auto& [flag, value] :
       {std::pair{"--mm-per-px", reading.mm_per_px}, std::pair{"--fps", reading.frame_rate_hz}})
    if (value && !(*value > 0)) throw UsageError(fmt::format("{} must be greater than 0", flag));
  const TrackFile track = read_any_track(options.track, reading);
  if (!track.facts.imported.empty())
    for (const std::string& warning : track.facts.warnings) say(context.quiet, "note: " + warning);
  GivenConditions given;
  if (options.angular_frequency && !(*options.angular_frequency > 0))
    throw UsageError("--omega-rad-s must be greater than 0");
  given.angular_frequency = options.angular_frequency;
  given.phase_shift = options.phase_shift;
  if (options.cycles) {
    if (!(*options.cycles >= 1 && *options.cycles <= 1e6) || *options.cycles != std::floor(*options.cycles))
      throw UsageError(fmt::format("--cycles must be a whole number, 1 to 1000000, not {}", *options.cycles));
    given.cycles = static_cast<int>(*options.cycles);
  }
  if (options.free_slide && options.angular_frequency)
    throw UsageError("--free-slide and --omega-rad-s contradict each other: a free slide's platform rests");
  if (options.free_slide) return measure_free_slide(options, track, context);
  RunMeasurement measurement = measure_run(options.track, track, given);
  for (std::string& difference : differences(options.track, measurement, given))
    measurement.warnings.push_back(std::move(difference));
  if (!measurement.displacement) return measure_free_slide(options, track, context);
  if (options.gravity)
    throw UsageError("--gravity-m-s2 belongs to free slides; this track shows a moving platform");
  write_and_print(
      options, track, {{"omega_rad_s", optional_json(given.angular_frequency)}, {"cycles", given.cycles}},
      {measurement_json(measurement, track), measurement_text(measurement, track), measurement.warnings},
      context);
  if (measurement.coded && measurement.coded->exceeds) {
    complain(fmt::format("{}: the coder's attenuation or delay exceeds the interval of what the track tells",
                         options.track));
    context.exit_code = kQualityGate;
  }
}

}  // namespace

void add_measure(CLI::App& app, Context& context) {
  auto options = std::make_shared<MeasureOptions>();
  CLI::App& command = *app.add_subcommand(
      "measure",
      "alpha, v and, where visible, the platform's motion, or a free slide's deceleration, from a track");
  command
      .add_option(
          "TRACK", options->track,
          "A table written by `tribotrack track`, or a track of Tracker, Kinovea, DLTdv, trackpy or another "
          "program (t_s,x_mm,y_mm)")
      ->type_name("T.csv")
      ->required();
  add_number(command, "--omega-rad-s", options->angular_frequency,
             "Angular frequency of the platform, where no marker shows it");
  add_angle(command, "--epsilon-rad", options->phase_shift,
            "Phase shift the platform should have: its sense is checked");
  add_number(command, "--cycles", options->cycles, "Whole cycles to measure over, at most (default 20)");
  command.add_flag(
      "--free-slide", options->free_slide,
      "The platform rests and the part slides: deceleration, stop and spin (also without this flag where "
      "no drive is given or seen)");
  add_number(command, "--gravity-m-s2", options->gravity,
             "Of a free slide: mu1 = deceleration / g (default 9.81)");
  add_number(command, "--mm-per-px", options->reading.mm_per_px,
             "Scale of another program's track that is in pixels");
  add_number(command, "--fps", options->reading.frame_rate_hz,
             "Rate at which the frames of another program's track were taken; beats its times");
  command
      .add_option("--track-unit", options->reading.unit,
                  "Unit of x and y of another program's track whose columns name none")
      ->check(one_of({"px", "um", "mm", "cm", "m"}));
  command
      .add_option("--track-y", options->track_y,
                  "Where its y points: up or down (default: down in pixels, up in lengths)")
      ->check(one_of({"up", "down"}));
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
      "measure slide.csv --free-slide\n  tribotrack measure tracker.txt --omega-rad-s 62.8 --track-unit mm");
  command.callback([options, &context] { measure_command(*options, context); });
}

}  // namespace tribotrack::apps
