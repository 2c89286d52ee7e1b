// tribotrack calibrate: pictures of a flat board to the camera's lens, the platform's plane and its scale.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "apps/commands/command.h"
#include "apps/files/calibration_file.h"
#include "apps/files/meta_file.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/angle.h"
#include "apps/text/number_text.h"
#include "apps/text/output_file.h"
#include "vision/calibration.h"

namespace tribotrack::apps {

namespace {

struct CalibrateOptions {
  std::vector<std::string> inputs;
  std::string plane, squares, output, dictionary = "4x4_50";
  std::optional<double> square_mm, square_sd_mm, marker_mm;
  bool json = false;
};

vision::CalibrationBoard board_of(const CalibrateOptions& options) {
  vision::CalibrationBoard board;
  const auto cross = std::min(options.squares.find('x'), options.squares.size());
  const double columns = parse_number(options.squares.substr(0, cross)).value_or(0);
  const double rows =
      cross + 1 < options.squares.size() ? parse_number(options.squares.substr(cross + 1)).value_or(0) : 0;
  const auto is_count = [](double n) { return n >= 1 && n <= 1000 && n == std::floor(n); };
  if (!is_count(columns) || !is_count(rows))
    throw UsageError(
        fmt::format("--squares must read COLUMNSxROWS, such as 10x7 (squares, not corners), not \"{}\"",
                    options.squares));
  board.columns = static_cast<int>(columns);
  board.rows = static_cast<int>(rows);
  for (const auto& [flag, length] :
       {std::pair{"--square-mm", options.square_mm}, std::pair{"--marker-mm", options.marker_mm}})
    if (length && !(*length > 0))
      throw UsageError(fmt::format("{} must be greater than 0, not {}", flag, *length));
  board.square_mm = *options.square_mm;
  board.dictionary = options.dictionary;
  if (options.marker_mm) {
    board.kind = vision::CalibrationBoard::Kind::charuco;
    board.marker_mm = *options.marker_mm;
  }
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
  print("focal length {:.1f} x {:.1f} px, middle ({:.1f}, {:.1f}) px, lens terms: {}\n", c.lens.fx, c.lens.fy,
        c.lens.cx, c.lens.cy, result.model);
  print("reprojection rms {:.4f} px\n\n{:>8} {:>9} {:>9} {:>9}  picture\n", result.rms_px, "corners",
        "rms px", "worst px", "tilt deg");
  for (const auto& p : result.pictures)
    print("{:>8} {:>9.4f} {:>9.4f} {:>9.1f}  {}\n", p.corners, p.rms_px, p.worst_px,
          p.tilt_rad * 180 / std::numbers::pi, p.name);
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
                        {"square_relative_sd", board.square_relative_sd},
                        {"marker_mm", board.marker_mm},
                        {"dictionary", board.dictionary}};
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
      "calibrate", "Pictures of a flat board to the camera's lens, the platform's plane and its scale");
  command
      .add_option(
          "PICTURES", options->inputs,
          "Pictures of the board, tilted by 15 to 45 degrees in several directions: files, folders, patterns "
          "dir/%05d.png or videos")
      ->required();
  command.add_option("--plane", options->plane, "A picture of the board lying on the platform")
      ->type_name("PICTURE")
      ->required();
  command.add_option("--squares", options->squares, "Squares of the board, not corners")
      ->type_name("COLUMNSxROWS")
      ->required();
  add_number(command, "--square-mm", options->square_mm, "Side of a square");
  command.get_option("--square-mm")->required();
  add_number(command, "--square-sd-mm", options->square_sd_mm,
             "Standard deviation of that side: enters the sd of the scale");
  add_number(command, "--marker-mm", options->marker_mm, "The board is a ChArUco board; side of its markers");
  command.add_option("--dictionary", options->dictionary, "Of the ChArUco board's markers (default 4x4_50)")
      ->type_name("NAME");
  command.add_option("-o,--output", options->output, "The calibration")
      ->type_name("calibration.json")
      ->required();
  command.add_flag("--json", options->json, "Print it as one JSON object");
  add_common(
      command, context,
      "  tribotrack calibrate board/*.png --plane flat.png --squares 10x7 --square-mm 2 -o calibration.json\n"
      "  tribotrack track phi000.cine --calibration calibration.json --height-mm 0.8 --marker auto -o t.csv");
  command.callback([options, &context] { calibrate_command(*options, context); });
}

}  // namespace tribotrack::apps
