// track(): a recording, or frames in memory.
#include <fmt/format.h>
#include <pybind11/numpy.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <utility>

#include "apps/files/run_folder.h"
#include "apps/files/track_rows.h"
#include "apps/program/context.h"
#include "apps/program/errors.h"
#include "apps/python/doors.h"
#include "apps/python/released.h"
#include "apps/python/values.h"
#include "apps/recording/check.h"
#include "apps/recording/record.h"
#include "apps/recording/track.h"
#include "apps/text/input_file.h"
#include "apps/text/output_file.h"
#include "vision/frame_source.h"
#include "vision/overlay.h"

namespace tribotrack::python {

namespace py = pybind11;
using apps::UsageError;

namespace {

std::optional<std::int64_t> frame_number(const py::handle& value) {
  if (value.is_none()) return std::nullopt;
  const double number = number_of("frames", value);
  if (number != std::floor(number))
    throw UsageError(fmt::format("--frames must hold the recording's own image numbers, not {}", number));
  return static_cast<std::int64_t>(number);
}

void set_frames(apps::TrackChoices& choices, const py::object& frames) {
  if (frames.is_none()) return;
  if (py::isinstance<py::str>(frames) || PySequence_Check(frames.ptr()) == 0 || py::len(frames) < 2 ||
      py::len(frames) > 3)
    throw UsageError(
        "--frames must be (first, last) or (first, last, step) in the recording's own image numbers, each of "
        "which may be None");
  choices.first_frame = frame_number(frames[py::int_(0)]);
  choices.last_frame = frame_number(frames[py::int_(1)]);
  if (py::len(frames) == 3) choices.frame_step = frame_number(frames[py::int_(2)]);
}

std::vector<std::int64_t> rectangle_of(const py::object& value) {
  const auto v =
      numbers_of("template", value, 4, "(x, y, width, height) in whole pixels, such as (100, 40, 41, 41)");
  for (const double number : v)
    if (number != std::floor(number) || std::abs(number) > 1e9)
      throw UsageError("--template must be whole pixels");
  return {v.begin(), v.end()};
}

/// The keyword of a flag: "mm_per_px".
std::string keyword(std::string_view flag) {
  std::string name(flag.substr(2));
  std::ranges::replace(name, '-', '_');
  return name;
}

apps::TrackChoices choices_of(const py::dict& options) {
  apps::TrackChoices choices;
  for (const apps::TrackFlag& flag : apps::kTrackNumbers)
    if (const auto value = number_in(options, keyword(flag.flag).c_str()))
      choices.keys[flag.section][flag.key] = *value;
  apps::Json& camera = choices.keys["camera"];
  if (const std::string reason = text_in(options, "fps_reason"); !reason.empty())
    camera["frame_rate_reason"] = reason;
  if (const auto disc = circle_in(options, "disc")) camera["disc_px"] = apps::circle_json(disc);
  if (const auto gate = circle_in(options, "gate")) camera["gate_px"] = apps::circle_json(gate);
  if (const py::object value = member(options, "template"); !value.is_none())
    camera["template_px"] = rectangle_of(value);
  if (const py::object marker = member(options, "marker"); py::isinstance<py::str>(marker))
    camera["marker"] = marker.cast<std::string>();
  else if (!marker.is_none())
    camera["marker_px"] = apps::circle_json(circle_in(options, "marker"));
  choices.calibration = text_in(options, "calibration");
  choices.config = text_in(options, "config");
  choices.layers = text_in(options, "layers");
  set_frames(choices, member(options, "frames"));
  return choices;
}

/// The levels of an array where they lie. Throws UsageError for what is no stack of grey pictures.
vision::FrameStack stack_of(const py::buffer_info& buffer) {
  const std::string expected =
      "frames must be an array of uint8 or uint16 grey levels of the shape (frames, height, width)";
  if (buffer.ndim != 3)
    throw UsageError(fmt::format("{}, not of {} dimensions{}", expected, buffer.ndim,
                                 buffer.ndim == 4 ? ": make grey of colour first" : ""));
  std::string format = buffer.format;
  if (format.size() == 2 && (format[0] == '@' || format[0] == '=' || format[0] == '|' ||
                             format[0] == (std::endian::native == std::endian::little ? '<' : '>')))
    format.erase(0, 1);
  if (format != "B" && format != "H")
    throw UsageError(
        fmt::format("{}, not of the type \"{}\": convert them with .astype", expected, buffer.format));
  for (const py::ssize_t count : buffer.shape)
    if (count < 1 || count > 1'000'000'000)
      throw UsageError(
          fmt::format("{}, not ({}, {}, {})", expected, buffer.shape[0], buffer.shape[1], buffer.shape[2]));
  return {buffer.ptr,
          format == "B" ? 1 : 2,
          buffer.shape[0],
          static_cast<int>(buffer.shape[2]),
          static_cast<int>(buffer.shape[1]),
          buffer.strides[0],
          buffer.strides[1],
          buffer.strides[2]};
}

struct Files {
  std::string output, overlay;
};

Files files_in(const py::dict& options, const std::string& source, const apps::TrackChoices& choices) {
  Files files{text_in(options, "output"), text_in(options, "overlay")};
  std::vector<apps::Output> outputs;
  if (!files.output.empty()) outputs.push_back({files.output});
  if (!files.overlay.empty()) outputs.push_back({files.overlay, apps::Content::pictures});
  if (outputs.empty()) return files;
  std::vector<std::filesystem::path> inputs;
  if (!source.empty()) inputs = apps::files_of_input(source);
  for (const std::string& file : {choices.config, choices.calibration})
    if (!file.empty()) inputs.emplace_back(file);
  apps::require_writable(outputs, inputs);
  if (!files.overlay.empty()) vision::require_overlay_name(files.overlay);
  return files;
}

/// What tracking hands to Python.
struct Tracked {
  apps::TrackRows rows;
  apps::Json meta;
  std::string failure;  ///< of its quality gate
};

Tracked finished(apps::Recording recording, const Files& files) {
  if (!files.overlay.empty()) apps::write_overlay_file(files.overlay, recording);
  if (!files.output.empty()) apps::write_track(files.output, recording);
  apps::Json meta = apps::meta_of(recording).json();
  meta["result_xxh3_128"] = apps::hash_of_text(apps::track_csv(recording.rows));  // as write_result() adds it
  std::string failure = apps::gate_failure(recording);
  return {std::move(recording.rows), std::move(meta), std::move(failure)};
}

Tracked track_file(apps::Recording recording, const Files& files, const Tell& tell) {
  recording.options.progress = [&tell](std::int64_t done, std::int64_t total) { tell("track", done, total); };
  return reading(vision::is_number_pattern(recording.video) ? "." : recording.video, [&] {
    std::optional<std::filesystem::path> beside;
    if (!files.output.empty()) beside = files.output;
    return finished(apps::tracked(apps::checked(recording), beside), files);
  });
}

Tracked track_stack(apps::Recording recording, const vision::FrameStack& stack, int bits, const Files& files,
                    const Tell& tell) {
  recording.options.progress = [&tell](std::int64_t done, std::int64_t total) { tell("track", done, total); };
  const auto source = std::make_shared<vision::StackSource>(stack, *recording.camera.frame_rate_hz, bits);
  return finished(apps::tracked(apps::checked_in_memory(std::move(recording)), source), files);
}

int bits_of(const py::dict& options, const vision::FrameStack& stack) {
  const auto given = whole_in(options, "bits");
  const int most = 8 * stack.bytes_per_level;
  if (given && (*given < 1 || *given > most))
    throw UsageError(fmt::format("--bits must be 1 to {} for levels of {} bytes, not {}", most,
                                 stack.bytes_per_level, *given));
  return static_cast<int>(given.value_or(most));
}

}  // namespace

py::dict track(const py::object& source, const py::dict& options, const py::object& progress) {
  const apps::TrackChoices choices = choices_of(options);
  apps::Context context;
  context.threads = static_cast<int>(whole_in(options, "threads").value_or(0));
  const bool file = is_path(source);
  const std::string name = file ? path_of(source) : "";
  const Files files = files_in(options, name, choices);
  apps::Recording recording = apps::recording_of(file ? name : "frames in memory", choices);
  recording.options.threads = apps::threads_to_use(context);
  Tracked result;
  if (file) {
    if (!member(options, "bits").is_none()) throw UsageError("--bits belongs to frames in memory");
    result = released<Tracked>(
        [recording, files](const Tell& tell) { return track_file(recording, files, tell); }, progress);
  } else {
    if (PyObject_CheckBuffer(source.ptr()) == 0)
      throw UsageError(fmt::format("the source must be a path or an array of frames, not {}",
                                   Py_TYPE(source.ptr())->tp_name));
    const auto buffer =
        std::make_shared<py::buffer_info>(py::reinterpret_borrow<py::buffer>(source).request());
    const vision::FrameStack stack = stack_of(*buffer);
    const int bits = bits_of(options, stack);
    if (!recording.camera.frame_rate_hz) throw UsageError("frames in memory have no frame rate: give --fps");
    result =
        released<Tracked>([recording, stack, bits, files](
                              const Tell& tell) { return track_stack(recording, stack, bits, files, tell); },
                          progress, buffer);
  }
  if (!result.failure.empty()) warn_of_quality(result.failure);
  py::dict dict = columns_of(result.rows);
  dict["meta"] = to_python(result.meta);
  return dict;
}

}  // namespace tribotrack::python
