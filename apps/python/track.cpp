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
#include "apps/python/calls.h"
#include "apps/recording/recording.h"
#include "apps/recording/track.h"
#include "apps/text/input_file.h"
#include "apps/text/output_file.h"
#include "vision/frame_source.h"
#include "vision/overlay.h"

namespace tribotrack::python {

namespace py = pybind11;
using apps::UsageError;

namespace {

void set_frames(apps::TrackChoices& choices, const Options& options) {
  const apps::Json* frames = options.find("frames");
  if (!frames) return;
  if (!frames->is_array() || frames->size() < 2 || frames->size() > 3)
    throw UsageError(
        "--frames must be (first, last) or (first, last, step) in the recording's own image numbers, each of "
        "which may be None");
  std::size_t k = 0;
  for (auto* choice : {&choices.first_frame, &choices.last_frame, &choices.frame_step}) {
    if (k == frames->size()) return;
    const apps::Json& value = (*frames)[k++];
    if (value.is_null()) continue;
    const double number = options.number_of("frames", value);
    if (number != std::floor(number))
      throw UsageError(fmt::format("--frames must hold the recording's own image numbers, not {}", number));
    *choice = static_cast<std::int64_t>(number);
  }
}

std::vector<std::int64_t> rectangle_in(const Options& options) {
  const auto v =
      options.numbers("template", 4, "(x, y, width, height) in whole pixels, such as (100, 40, 41, 41)");
  for (const double number : *v)
    if (number != std::floor(number) || std::abs(number) > 1e9)
      throw UsageError("--template must be whole pixels");
  return {v->begin(), v->end()};
}

/// The keyword of a flag: "mm_per_px".
std::string keyword(std::string_view flag) {
  std::string name(flag.substr(2));
  std::ranges::replace(name, '-', '_');
  return name;
}

apps::TrackChoices choices_of(const Options& options) {
  apps::TrackChoices choices;
  for (const apps::TrackFlag& flag : apps::kTrackNumbers)
    if (const auto value = options.number(keyword(flag.flag))) choices.keys[flag.section][flag.key] = *value;
  apps::Json& camera = choices.keys["camera"];
  if (const std::string reason = options.text("fps_reason"); !reason.empty())
    camera["frame_rate_reason"] = reason;
  if (const auto disc = options.circle("disc")) camera["disc_px"] = apps::circle_json(disc);
  if (const auto gate = options.circle("gate")) camera["gate_px"] = apps::circle_json(gate);
  if (options.find("template")) camera["template_px"] = rectangle_in(options);
  if (const apps::Json* marker = options.find("marker"); marker && marker->is_string())
    camera["marker"] = *marker;
  else if (marker)
    camera["marker_px"] = apps::circle_json(options.circle("marker"));
  choices.calibration = options.text("calibration");
  choices.config = options.text("config");
  choices.layers = options.text("layers");
  set_frames(choices, options);
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

Files files_in(const Options& options, const std::string& source, const apps::TrackChoices& choices) {
  Files files{options.text("output"), options.text("overlay")};
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

/// NaN for an empty cell.
py::dict columns_of(const apps::TrackRows& table) {
  py::dict dict;
  py::array_t<std::int64_t> frames(static_cast<py::ssize_t>(table.rows.size()));
  std::vector<double> values;
  for (const apps::TrackRow& row : table.rows) {
    frames.mutable_at(static_cast<py::ssize_t>(values.size())) = row.frame;
    values.push_back(row.time_s);
  }
  dict["frame"] = frames;
  dict["time_s"] = array_of(values);
  apps::for_each_column(table, [&](const char* name, double apps::TrackRow::*number) {
    py::list words;
    values.clear();
    for (const apps::TrackRow& row : table.rows)
      if (number != nullptr)
        values.push_back(row.*number);
      else
        words.append(vision::to_string(row.status));
    dict[name] = number != nullptr ? py::object(array_of(values)) : py::object(words);
  });
  return dict;
}

int bits_of(const Options& options, const vision::FrameStack& stack) {
  const auto given = options.whole("bits");
  const int most = 8 * stack.bytes_per_level;
  if (given && (*given < 1 || *given > most))
    throw UsageError(fmt::format("--bits must be 1 to {} for levels of {} bytes, not {}", most,
                                 stack.bytes_per_level, *given));
  return static_cast<int>(given.value_or(most));
}

/// The levels in memory as a recording.
std::shared_ptr<vision::FrameSource> source_of(const vision::FrameStack& stack,
                                               const apps::Recording& recording, const Options& options) {
  const int bits = bits_of(options, stack);
  if (!recording.camera.frame_rate_hz) throw UsageError("frames in memory have no frame rate: give --fps");
  return std::make_shared<vision::StackSource>(stack, *recording.camera.frame_rate_hz, bits);
}

}  // namespace

Returned track(const std::string& path, const std::string& json, const py::function& tell,
               const py::object& frames) {
  const Options options(json);
  const apps::TrackChoices choices = choices_of(options);
  apps::Context context;
  context.threads = static_cast<int>(options.whole("threads").value_or(0));
  const Files files = files_in(options, path, choices);
  apps::Recording recording = apps::recording_of(frames.is_none() ? path : "frames in memory", choices);
  recording.options.threads = apps::threads_to_use(context);
  py::buffer_info buffer;
  std::shared_ptr<vision::FrameSource> memory;
  if (!frames.is_none()) {
    if (PyObject_CheckBuffer(frames.ptr()) == 0)
      throw UsageError(fmt::format("the source must be a path or an array of frames, not {}",
                                   Py_TYPE(frames.ptr())->tp_name));
    buffer = py::reinterpret_borrow<py::buffer>(frames).request();
    memory = source_of(stack_of(buffer), recording, options);
  } else if (options.find("bits")) {
    throw UsageError("--bits belongs to frames in memory");
  }
  apps::Json meta;
  std::vector<std::string> doubts;
  without_lock(tell, [&](const Tell& told) {
    recording.options.progress = [&told](std::int64_t done, std::int64_t total) {
      told("track", done, total);
    };
    std::optional<std::filesystem::path> beside;
    if (!files.output.empty()) beside = files.output;
    recording = memory ? apps::tracked(apps::checked_in_memory(std::move(recording)), memory)
                       : apps::tracked(apps::checked(std::move(recording)), beside);
    if (!files.overlay.empty()) apps::write_overlay_file(files.overlay, recording);
    if (!files.output.empty()) apps::write_track(files.output, recording);
    meta["meta"] = apps::meta_of(recording).json();
    meta["meta"]["result_xxh3_128"] =
        apps::hash_of_text(apps::track_csv(recording.rows));  // as write_result()
    if (const std::string failure = apps::gate_failure(recording); !failure.empty())
      doubts.push_back(failure);
  });
  return {columns_of(recording.rows), meta.dump(-1, ' ', false, apps::Json::error_handler_t::replace),
          doubts};
}

}  // namespace tribotrack::python
