// measure() and fit(): from tracks to parameters.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/numpy.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "apps/campaign/fit_stage.h"
#include "apps/files/campaign/campaign.h"
#include "apps/files/scenario_file.h"
#include "apps/files/track_file.h"
#include "apps/files/tracks/any_track.h"
#include "apps/measuring/measure_track.h"
#include "apps/pipeline/fit_campaign.h"
#include "apps/program/context.h"
#include "apps/program/errors.h"
#include "apps/python/doors.h"
#include "apps/python/released.h"
#include "apps/python/values.h"
#include "apps/simulating/simulation.h"
#include "apps/simulating/sweep.h"
#include "model/trajectory.h"

namespace tribotrack::python {

namespace py = pybind11;
using apps::UsageError;

namespace {

/// What a table in memory is called in messages.
constexpr const char* kTrack = "track";
constexpr const char* kCampaign = "campaign";

apps::Track track_in(const py::object& track) {
  if (!py::hasattr(track, "keys"))
    throw UsageError(
        fmt::format("the track must be a path or a dict of columns, not {}", Py_TYPE(track.ptr())->tp_name));
  std::optional<apps::Json> meta;
  if (track.contains("meta")) {
    const py::object given = track["meta"];
    if (!given.is_none()) meta = to_json(given, kTrack);
  }
  return apps::track_of_text(kTrack, csv_of(track, kTrack), meta);
}

apps::FitChoices choices_of(const py::dict& options) {
  apps::FitChoices choices;
  choices.tracks = text_in(options, "tracks");
  choices.loss = text_in(options, "loss");
  const auto whole = [&](const char* name, long least, long most) {
    const long value = whole_in(options, name).value_or(least);
    if (value < least || value > most)
      throw UsageError(fmt::format("--{} must be {} to {}, not {}", name, least, most, value));
    return value;
  };
  choices.allow_missing = static_cast<int>(whole("allow_missing", 0, 1'000'000));
  choices.fit.bootstrap = static_cast<int>(whole("bootstrap", 0, 1'000'000));
  if (choices.fit.bootstrap > 0 && choices.fit.bootstrap < 20)
    throw UsageError(fmt::format("--bootstrap must be 0 or at least 20, not {}", choices.fit.bootstrap));
  choices.fit.bootstrap_seed = static_cast<unsigned>(whole("seed", 0, 4294967295));
  choices.fit.rivals = truth_in(options, "compare_models");
  return choices;
}

/// What fitting hands to Python.
struct Fitted {
  apps::Json json;
  std::vector<apps::Reservation> reservations;
};

/// How another program's track is to be read.
apps::TrackReading reading_of(const py::dict& options) {
  const auto above_zero = [&](const char* key) {
    const auto value = number_in(options, key);
    if (value && !(*value > 0)) throw UsageError(fmt::format("{} must be greater than 0", key));
    return value;
  };
  const auto one_of = [&](const char* key, const std::vector<std::string>& words) {
    std::string word = text_in(options, key);
    if (!word.empty() && std::ranges::find(words, word) == words.end())
      throw UsageError(fmt::format("{} must be one of {}, not \"{}\"", key, fmt::join(words, ", "), word));
    return word;
  };
  apps::TrackReading reading;
  reading.unit = one_of("track_unit", {"px", "um", "mm", "cm", "m"});
  reading.y = one_of("track_y", {"up", "down"});
  reading.frame = one_of("track_frame", {"platform", "camera"});
  reading.point = text_in(options, "track_point");
  reading.mark = text_in(options, "track_mark");
  reading.mm_per_px = above_zero("mm_per_px");
  reading.frame_rate_hz = above_zero("fps");
  return reading;
}

}  // namespace

py::dict measure(const py::object& track, const py::dict& options) {
  apps::MeasureChoices choices;
  choices.omega_rad_s = number_in(options, "omega_rad_s");
  choices.epsilon_rad = number_in(options, "epsilon_rad");
  choices.cycles = number_in(options, "cycles");
  choices.gravity_m_s2 = number_in(options, "gravity_m_s2");
  choices.free_slide = truth_in(options, "free_slide");
  const apps::TrackReading how = reading_of(options);
  const std::string name = is_path(track) ? path_of(track) : kTrack;
  std::optional<apps::Track> given;
  if (!is_path(track)) given = track_in(track);
  const auto result = released<apps::TrackMeasurement>([name, how, choices, given](const Tell&) {
    const apps::Track table = given ? *given : reading(name, [&] { return apps::read_any_track(name, how); });
    return apps::measure_track(name, table, choices);
  });
  if (!result.failure.empty()) warn_of_quality(result.failure);
  return to_python(result.json);
}

py::dict fit(const py::object& campaign, const py::dict& options, const py::object& progress) {
  const apps::FitChoices choices = choices_of(options);
  const std::string part = text_in(options, "part");
  apps::Context context;
  context.quiet = true;
  context.threads = static_cast<int>(whole_in(options, "threads").value_or(0));
  std::shared_ptr<const apps::Campaign> read;
  if (is_path(campaign)) {
    const std::string file = path_of(campaign);
    read = reading(file, [&] {
      return std::make_shared<const apps::Campaign>(
          apps::campaign_of_part(apps::read_campaign(apps::campaign_file(file)), part));
    });
  } else {
    if (!py::isinstance<py::dict>(campaign))
      throw UsageError(fmt::format("the campaign must be a path, a dict or a table, not {}",
                                   Py_TYPE(campaign.ptr())->tp_name));
    read = std::make_shared<const apps::Campaign>(
        apps::campaign_of_part(apps::campaign_of(to_json(campaign, kCampaign), kCampaign), part));
  }
  const auto result = released<Fitted>(
      [read, choices, context](const Tell& tell) mutable {
        context.progress = tell;
        apps::FittedCampaign fitted = apps::fit_campaign(*read, choices, context);
        auto found = apps::reservations(*read, fitted, "identifiability and next_experiment");
        return Fitted{std::move(fitted.json), std::move(found)};
      },
      progress);
  for (const apps::Reservation& reservation : result.reservations) {
    std::string sentence = reservation.sentence;
    for (const std::string& remedy : reservation.remedies) sentence += "\n  " + remedy;
    warn_of_quality(sentence);
  }
  return to_python(result.json);
}

// simulate() and sweep().

namespace {

apps::GivenScenario given_by(const py::object& scenario, const py::dict& values) {
  apps::GivenScenario given;
  if (!scenario.is_none()) given.file = path_of(scenario);
  given.start = text_in(values, "start");
  given.samples_per_cycle = number_in(values, "samples_per_cycle");
  for (const auto& [key, value] : values) {
    const auto name = key.cast<std::string>();
    if (name != "start" && name != "samples_per_cycle" && !value.is_none())
      given.values.emplace_back(name, number_of(name, value));
  }
  return given;
}

/// What a simulation computes without Python.
struct Simulated {
  apps::Json results;
  std::array<std::vector<double>, 6> columns;
  std::vector<char> slips;
};
constexpr std::array<const char*, 6> kColumns = {"time_s", "x_mm", "y_mm", "vx_mm_s", "vy_mm_s", "mu"};

Simulated simulated(const apps::GivenScenario& given, const Tell& tell) {
  const apps::ScenarioFile file =
      reading(given.file.empty() ? "." : given.file, [&] { return scenario_of(given); });
  apps::require_sensible_table("simulate", file.scenario, file.samples_per_cycle);
  const model::Trajectory trajectory = model::integrate(file.scenario);
  Simulated result;
  result.results = apps::simulation_json(trajectory);
  apps::for_each_row(trajectory, file.samples_per_cycle, [&](const apps::SimulatedRow& row) {
    constexpr std::size_t now_and_then = 4096;
    if (result.slips.size() % now_and_then == 0) tell("simulate", 0, 1);
    const std::array values = {row.time_s, row.x_mm, row.y_mm, row.vx_mm_s, row.vy_mm_s, row.mu};
    for (std::size_t k = 0; k < values.size(); ++k) result.columns[k].push_back(values[k]);
    result.slips.push_back(std::string_view(row.state) == "slip");
  });
  return result;
}

/// "slip" and "stick", as NumPy's texts.
py::object states_of(const std::vector<char>& slips) {
  const py::module_ numpy = py::module_::import("numpy");
  const py::array_t<bool> slipping(static_cast<py::ssize_t>(slips.size()),
                                   reinterpret_cast<const bool*>(slips.data()));
  return numpy.attr("where")(slipping, "slip", "stick");
}

/// One or two axes, in the order of the dict.
std::vector<apps::SweepAxis> axes_of(const py::object& over) {
  if (!py::isinstance<py::dict>(over))
    throw apps::UsageError("--over must be a dict of one or two names with their values");
  std::vector<apps::SweepAxis> axes;
  for (const auto& [key, values] : py::reinterpret_borrow<py::dict>(over)) {
    const auto name = key.cast<std::string>();
    std::vector<double> numbers;
    for (const py::handle& value : py::iter(values)) numbers.push_back(number_of(name, value));
    axes.emplace_back(name, std::move(numbers));
  }
  apps::require_sweepable(axes);
  return axes;
}

}  // namespace

py::dict simulate(const py::object& scenario, const py::dict& values) {
  const apps::GivenScenario given = given_by(scenario, values);
  const auto result = released<Simulated>([given](const Tell& tell) { return simulated(given, tell); });
  py::dict dict;
  for (std::size_t k = 0; k < kColumns.size(); ++k) dict[kColumns[k]] = array_of(result.columns[k]);
  dict["state"] = states_of(result.slips);
  dict.attr("update")(to_python(result.results));
  return dict;
}

py::dict sweep(const py::object& scenario, const py::object& over, const py::dict& values,
               const py::object& threads, const py::object& progress) {
  const apps::GivenScenario given = given_by(scenario, values);
  const apps::ScenarioFile base =
      reading(given.file.empty() ? "." : given.file, [&] { return apps::base_of(given); });
  const apps::Sweep swept(base, over.is_none() ? apps::sweep_axes(base.over) : axes_of(over));
  apps::Context context;
  context.quiet = true;
  context.threads = threads.is_none() ? 0 : static_cast<int>(number_of("threads", threads));
  const auto solved = released<apps::SweptModel>(
      [swept, context](const Tell& tell) mutable {
        context.progress = tell;
        return apps::solve(swept, context);
      },
      progress);
  py::dict dict;
  std::vector<py::ssize_t> shape;
  for (const apps::SweepAxis& axis : swept.axes()) {
    std::vector<double> along;
    for (std::size_t k = 0; k < axis.count(); ++k) along.push_back(axis.value(k));
    dict[py::str(axis.name())] = array_of(along);
    shape.push_back(static_cast<py::ssize_t>(axis.count()));
  }
  const auto put = [&](const char* name, const std::vector<double>& column) {
    dict[name] = py::array_t<double>(shape, column.data());
  };
  put("alpha_rad", solved.alpha_rad);
  put("v_mm_s", solved.v_mm_s);
  put("steady_alpha_rad", solved.steady_alpha_rad);
  put("steady_v_mm_s", solved.steady_v_mm_s);
  return dict;
}

}  // namespace tribotrack::python

// tribotrack._core: what tribotrack/__init__.py is written on.
PYBIND11_MODULE(_core, module) {
  namespace py = pybind11;
  namespace python = tribotrack::python;
  module.doc() = "The program's rooms as Python's functions; use tribotrack, which documents them.";
  module.attr("__version__") = TRIBOTRACK_VERSION;
  python::translate_errors();
  module.def("simulate", &python::simulate, py::arg("scenario"), py::arg("values"));
  module.def("sweep", &python::sweep, py::arg("scenario"), py::arg("over"), py::arg("values"),
             py::arg("threads"), py::arg("progress"));
  module.def("track", &python::track, py::arg("source"), py::arg("options"), py::arg("progress"));
  module.def("measure", &python::measure, py::arg("track"), py::arg("options"));
  module.def("fit", &python::fit, py::arg("campaign"), py::arg("options"), py::arg("progress"));
  module.def("scenario_parameter_names", [] {
    py::list names;
    for (const std::string& name : tribotrack::apps::scenario_parameter_names()) names.append(name);
    return names;
  });
  py::module_::import("atexit").attr("register")(py::cpp_function(&python::wait_for_stopped_work));
}
