// simulate(), sweep(), measure() and fit(), and the module itself.
#include "apps/python/calls.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "apps/campaign/fit_stage.h"
#include "apps/files/campaign/campaign.h"
#include "apps/files/scenario_file.h"
#include "apps/files/track_file.h"
#include "apps/files/tracks/any_track.h"
#include "apps/measuring/measure_track.h"
#include "apps/pipeline/line.h"
#include "apps/program/context.h"
#include "apps/program/errors.h"
#include "apps/recording/track.h"
#include "apps/simulating/simulation.h"
#include "apps/simulating/sweep.h"
#include "apps/text/angle.h"
#include "fit/measurement.h"
#include "model/trajectory.h"

namespace tribotrack::python {

namespace py = pybind11;
using apps::flag_of;
using apps::Json;
using apps::UsageError;

namespace {

std::string shown(const Json& value) {
  return value.is_string() ? "'" + value.get<std::string>() + "'" : value.dump();
}

/// None is a key that is not there.
void drop_none(Json& json) {
  for (auto item = json.begin(); json.is_structured() && item != json.end();) {
    if (json.is_object() && item->is_null()) {
      item = json.erase(item);
    } else {
      drop_none(*item);
      ++item;
    }
  }
}

}  // namespace

Options::Options(const std::string& json) : values_(Json::parse(json)) {
  drop_none(values_);
}

const Json* Options::find(const std::string& name) const {
  const auto found = values_.find(name);
  return found == values_.end() ? nullptr : &*found;
}

double Options::number_of(const std::string& name, const Json& value) const {
  const bool angle = name.ends_with("_rad");
  std::optional<double> number;
  if (value.is_number()) number = value.get<double>();
  if (angle && value.is_string()) number = apps::parse_angle(value.get<std::string>());
  if (!number)
    throw UsageError(fmt::format(
        "{} must be {}, not {}", flag_of(name),
        angle ? "an angle such as 0.5 (radians), pi/2, 11pi/9 or 90deg" : "a finite number", shown(value)));
  if (const std::string slip = angle ? apps::angle_slip(*number) : ""; !slip.empty())
    throw UsageError(fmt::format("{}: {}", flag_of(name), slip));
  return *number;
}

std::optional<double> Options::number(const std::string& name) const {
  const Json* value = find(name);
  return value ? std::optional(number_of(name, *value)) : std::nullopt;
}

std::string Options::text(const std::string& name) const {
  const Json* value = find(name);
  if (value && !value->is_string())
    throw UsageError(fmt::format("{} must be a text, not {}", flag_of(name), shown(*value)));
  return value ? value->get<std::string>() : "";
}

bool Options::truth(const std::string& name) const {
  const Json* value = find(name);
  return value && *value == true;
}

std::optional<long> Options::whole(const std::string& name) const {
  const auto value = number(name);
  constexpr double largest = 0x1p53;
  if (value && (*value != std::floor(*value) || std::abs(*value) > largest))
    throw UsageError(fmt::format("{} must be a whole number, not {}", flag_of(name), *value));
  return value ? std::optional(static_cast<long>(*value)) : std::nullopt;
}

std::optional<std::vector<double>> Options::numbers(const std::string& name, std::size_t count,
                                                    const char* form) const {
  const Json* value = find(name);
  if (!value) return std::nullopt;
  if (!value->is_array() || value->size() != count || !std::ranges::all_of(*value, &Json::is_number))
    throw UsageError(fmt::format("{} must be {}, not {}", flag_of(name), form, shown(*value)));
  return value->get<std::vector<double>>();
}

std::optional<vision::Circle> Options::circle(const std::string& name) const {
  const auto v = numbers(name, 3, "(x, y, radius) in pixels, such as (640, 400, 150)");
  return v ? std::optional(vision::Circle{(*v)[0], (*v)[1], (*v)[2]}) : std::nullopt;
}

namespace {

struct Stop {};

}  // namespace

Tell teller(const py::function& tell) {
  using Clock = std::chrono::steady_clock;
  const auto next = std::make_shared<std::atomic<Clock::time_point>>();
  return [next, called = tell.ptr()](const std::string& stage, std::int64_t done, std::int64_t total) {
    const Clock::time_point now = Clock::now();
    Clock::time_point due = *next;
    if (now < due || !next->compare_exchange_strong(due, now + std::chrono::milliseconds(50))) return;
    const py::gil_scoped_acquire locked;
    try {
      py::handle{called}(stage, done, total);
    } catch (const py::error_already_set&) {
      throw Stop{};
    }
  };
}

namespace {

/// As the program's files have it: what is not finite is null.
std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

apps::Context quiet_context(const Options& options) {
  apps::Context context;
  context.quiet = true;
  context.threads = static_cast<int>(options.whole("threads").value_or(0));
  return context;
}

apps::GivenScenario scenario_given(const std::string& path, const Options& options) {
  apps::GivenScenario given;
  given.file = path;
  given.start = options.text("start");
  given.samples_per_cycle = options.number("samples_per_cycle");
  for (const auto& [name, value] : options.all().items())
    if (name != "start" && name != "samples_per_cycle" && name != "over" && name != "threads")
      given.values.emplace_back(name, options.number_of(name, value));
  return given;
}

Returned simulate(const std::string& path, const std::string& json, const py::function& tell) {
  const apps::GivenScenario given = scenario_given(path, Options(json));
  constexpr std::array names = {"time_s", "x_mm", "y_mm", "vx_mm_s", "vy_mm_s", "mu"};
  std::array<std::vector<double>, names.size()> columns;
  std::vector<const char*> states;
  const Json results = without_lock(tell, [&](const Tell& told) {
    const apps::ScenarioFile file = scenario_of(given);
    apps::require_sensible_table("simulate", file.scenario, file.samples_per_cycle);
    const model::Trajectory trajectory = model::integrate(file.scenario);
    apps::for_each_row(trajectory, file.samples_per_cycle, [&](const apps::SimulatedRow& row) {
      told("simulate", 0, 1);
      const std::array values = {row.time_s, row.x_mm, row.y_mm, row.vx_mm_s, row.vy_mm_s, row.mu};
      for (std::size_t k = 0; k < values.size(); ++k) columns[k].push_back(values[k]);
      states.push_back(row.state);
    });
    return apps::simulation_json(trajectory);
  });
  py::dict table;
  for (std::size_t k = 0; k < names.size(); ++k) table[names[k]] = array_of(columns[k]);
  table["state"] = states;
  return {table, text_of(results), {}};
}

/// One or two axes, in the order of the dict.
std::vector<apps::SweepAxis> axes_of(const Options& options, const Json& over) {
  std::vector<apps::SweepAxis> axes;
  for (const auto& [name, values] : over.items()) {
    std::vector<double> numbers;
    for (const Json& value : values) numbers.push_back(options.number_of(name, value));
    axes.emplace_back(name, std::move(numbers));
  }
  apps::require_sweepable(axes);
  return axes;
}

Returned sweep(const std::string& path, const std::string& json, const py::function& tell) {
  const Options options(json);
  const apps::ScenarioFile base = apps::base_of(scenario_given(path, options));
  const Json* over = options.find("over");
  const apps::Sweep swept(base, over ? axes_of(options, *over) : apps::sweep_axes(base.over));
  apps::Context context = quiet_context(options);
  const apps::SweptModel solved = without_lock(tell, [&](const Tell& told) {
    context.progress = told;
    return apps::solve(swept, context);
  });
  py::dict table;
  std::vector<py::ssize_t> shape;
  for (const apps::SweepAxis& axis : swept.axes()) {
    std::vector<double> along;
    for (std::size_t k = 0; k < axis.count(); ++k) along.push_back(axis.value(k));
    table[py::str(axis.name())] = array_of(along);
    shape.push_back(static_cast<py::ssize_t>(axis.count()));
  }
  for (const auto& [name, column] : {std::pair("alpha_rad", &solved.alpha_rad),
                                     {"v_mm_s", &solved.v_mm_s},
                                     {"steady_alpha_rad", &solved.steady_alpha_rad},
                                     {"steady_v_mm_s", &solved.steady_v_mm_s}})
    table[name] = py::array_t<double>(shape, column->data());
  return {table, "{}", {}};
}

/// How another program's track is to be read.
apps::TrackReading reading_of(const Options& options) {
  const auto above_zero = [&](const char* key) {
    const auto value = options.number(key);
    if (value && !(*value > 0)) throw UsageError(fmt::format("{} must be greater than 0", key));
    return value;
  };
  const auto one_of = [&](const char* key, const std::vector<std::string>& words) {
    std::string word = options.text(key);
    if (!word.empty() && std::ranges::find(words, word) == words.end())
      throw UsageError(fmt::format("{} must be one of {}, not \"{}\"", key, fmt::join(words, ", "), word));
    return word;
  };
  apps::TrackReading reading;
  reading.unit = one_of("track_unit", {"px", "um", "mm", "cm", "m"});
  reading.y = one_of("track_y", {"up", "down"});
  reading.frame = one_of("track_frame", {"platform", "camera"});
  reading.point = options.text("track_point");
  reading.mark = options.text("track_mark");
  reading.mm_per_px = above_zero("mm_per_px");
  reading.frame_rate_hz = above_zero("fps");
  return reading;
}

/// Without a path, `csv` and `meta` hold the track.
Returned measure(const std::string& path, const std::string& json, const py::function& tell) {
  constexpr const char* kInMemory = "track";
  const Options options(json);
  apps::MeasureChoices choices;
  choices.omega_rad_s = options.number("omega_rad_s");
  choices.epsilon_rad = options.number("epsilon_rad");
  choices.cycles = options.number("cycles");
  choices.gravity_m_s2 = options.number("gravity_m_s2");
  choices.free_slide = options.truth("free_slide");
  const apps::TrackReading how = reading_of(options);
  const Json* meta = options.find("meta");
  const apps::TrackMeasurement result = without_lock(tell, [&](const Tell&) {
    if (!path.empty()) return apps::measure_track(path, apps::read_any_track(path, how), choices);
    return apps::measure_track(
        kInMemory,
        apps::track_of_text(kInMemory, options.text("csv"), meta ? std::optional(*meta) : std::nullopt),
        choices);
  });
  return {{},
          text_of(result.json),
          result.failure.empty() ? std::vector<std::string>{} : std::vector{result.failure}};
}

apps::FitChoices fit_choices(const Options& options) {
  apps::FitChoices choices;
  choices.tracks = options.text("tracks");
  choices.loss = options.text("loss");
  const auto whole = [&](const char* name, long least, long most) {
    const long value = options.whole(name).value_or(least);
    if (value < least || value > most)
      throw UsageError(fmt::format("--{} must be {} to {}, not {}", name, least, most, value));
    return value;
  };
  choices.allow_missing = static_cast<int>(whole("allow_missing", 0, 1'000'000));
  choices.fit.bootstrap = static_cast<int>(whole("bootstrap", 0, 1'000'000));
  if (choices.fit.bootstrap > 0 && choices.fit.bootstrap < 20)
    throw UsageError(fmt::format("--bootstrap must be 0 or at least 20, not {}", choices.fit.bootstrap));
  choices.fit.bootstrap_seed = static_cast<unsigned>(whole("seed", 0, 4294967295));
  choices.fit.rivals = options.truth("compare_models");
  return choices;
}

/// Without a path, `campaign` holds a campaign file's structure.
Returned fit(const std::string& path, const std::string& json, const py::function& tell) {
  const Options options(json);
  const apps::FitChoices choices = fit_choices(options);
  apps::Context context = quiet_context(options);
  const apps::Campaign campaign =
      apps::campaign_of_part(path.empty() ? apps::campaign_of(options.all().at("campaign"), "campaign")
                                          : apps::read_campaign(apps::campaign_file(path)),
                             options.text("part"));
  std::vector<std::string> doubts;
  const Json result = without_lock(tell, [&](const Tell& told) {
    context.progress = told;
    const apps::FittedCampaign fitted = apps::fit_campaign(campaign, choices, context);
    for (const apps::Reservation& one :
         apps::reservations(campaign, fitted, "identifiability and next_experiment")) {
      doubts.push_back(one.sentence);
      for (const std::string& remedy : one.remedies) doubts.back() += "\n  " + remedy;
    }
    return fitted.json;
  });
  return {{}, text_of(result), doubts};
}

// What the program refuses, as the exceptions of tribotrack/_errors.py.

void raise(const char* type, const std::exception& refused, const apps::AmbiguousPart* question = nullptr) {
  const py::object exception = py::module_::import("tribotrack._errors").attr(type)(refused.what());
  if (question) {
    py::list discs;
    for (const vision::Circle& disc : question->discs)
      discs.append(py::make_tuple(disc.x, disc.y, disc.radius));
    exception.attr("frame") = question->frame;
    exception.attr("discs_px") = discs;
  }
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(exception.ptr())), exception.ptr());
}

void translate(std::exception_ptr error) {
  try {
    if (error) std::rethrow_exception(error);
  } catch (const apps::AmbiguousPart& question) {
    raise("AmbiguousPartError", question, &question);
  } catch (const apps::UsageError& refused) {
    raise("InputError", refused);
  } catch (const apps::InvalidInput& refused) {
    raise("InputError", refused);
  } catch (const vision::InputError& refused) {
    raise("InputError", refused);
  } catch (const fit::DataError& refused) {
    raise("InputError", refused);
  } catch (const std::invalid_argument& refused) {  // model::InvalidParameter, too
    raise("InputError", refused);
  } catch (const model::StepLimitExceeded& refused) {
    raise("InputError", refused);
  } catch (const Stop&) {
    PyErr_SetNone(PyExc_InterruptedError);
  }
}

}  // namespace

}  // namespace tribotrack::python

PYBIND11_MODULE(_core, module) {
  namespace py = pybind11;
  namespace python = tribotrack::python;
  module.doc() = "The program's rooms as Python's functions; use tribotrack, which documents them.";
  module.attr("__version__") = TRIBOTRACK_VERSION;
  py::register_exception_translator(&python::translate);
  for (const auto& [name, function] : {std::pair("simulate", &python::simulate),
                                       {"sweep", &python::sweep},
                                       {"measure", &python::measure},
                                       {"fit", &python::fit}})
    module.def(name, function, py::arg("path"), py::arg("options"), py::arg("tell"));
  module.def("track", &python::track, py::arg("path"), py::arg("options"), py::arg("tell"),
             py::arg("frames"));
  module.def("scenario_parameter_names", &tribotrack::apps::scenario_parameter_names);
}
