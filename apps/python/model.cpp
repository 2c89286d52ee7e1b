// simulate() and sweep().
#include <pybind11/numpy.h>

#include <array>
#include <utility>
#include <vector>

#include "apps/files/sweeps/sweep_axis.h"
#include "apps/program/context.h"
#include "apps/program/errors.h"
#include "apps/python/doors.h"
#include "apps/python/errors.h"
#include "apps/python/released.h"
#include "apps/python/values.h"
#include "apps/simulating/given_scenario.h"
#include "apps/simulating/simulation.h"
#include "apps/simulating/swept_model.h"
#include "model/trajectory.h"

namespace tribotrack::python {

namespace py = pybind11;

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
