#include "apps/simulating/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/simulating/sweep.h"
#include "apps/text/angle.h"
#include "model/alpha_v.h"
#include "model/parallel.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::apps {

std::string flag_of(std::string parameter) {
  std::ranges::replace(parameter, '_', '-');
  return "--" + parameter;
}

namespace {

/// The parameter, by one name of several; mu2 for its ratio.
std::string meaning_of(const std::string& name) {
  const std::string parameter = scenario_parameter_named(name);
  return parameter == "mu1_over_mu2" ? "mu2" : parameter.empty() ? name : parameter;
}

}  // namespace

ScenarioFile base_of(const GivenScenario& given) {
  std::map<std::string, std::string> names;  // by what they mean
  for (const auto& [name, value] : given.values) {
    if (!value) continue;
    if (const auto [other, is_new] = names.emplace(meaning_of(name), name); !is_new)
      throw UsageError("{} and {} mean the same; give one of them", flag_of(other->second), flag_of(name));
  }
  ScenarioFile file = given.file.empty() ? ScenarioFile{} : read_scenario_file(given.file);
  // amplitude_mm sets both axes, amplitude_y_mm the second: in this order, whatever the order they came in.
  for (const bool of_y : {false, true})
    for (const auto& [name, value] : given.values)
      if (value && (name == "amplitude_y_mm") == of_y) set_scenario_parameter(file, name, *value);
  if (!given.start.empty()) file.scenario.start = parse_start(given.start);
  if (given.samples_per_cycle) {
    if (!(*given.samples_per_cycle >= 1 && *given.samples_per_cycle <= 1e6))
      throw UsageError("--samples-per-cycle must be between 1 and 1000000");
    file.samples_per_cycle = static_cast<int>(*given.samples_per_cycle);
  }
  return file;
}

ScenarioFile scenario_of(const GivenScenario& given) {
  ScenarioFile file = base_of(given);
  file.settle();
  file.scenario.validate();
  return file;
}

namespace {

double intervals_of(const model::Scenario& scenario, int samples_per_cycle) {
  return std::ceil(scenario.cycles * samples_per_cycle);
}

}  // namespace

Json simulation_json(const model::Trajectory& trajectory) {
  const auto& scenario = trajectory.scenario();
  const model::Sample end = trajectory.end();
  Json json;
  json["end_x_mm"] = end.position.x() * 1e3;
  json["end_y_mm"] = end.position.y() * 1e3;
  const bool moved = end.position.norm() > 0;
  json["alpha_rad"] = moved ? Json(model::displacement_angle(end.position)) : Json();
  json["v_mm_s"] = model::mean_velocity(end.position, trajectory.end_time()) * 1e3;
  json["cycles"] = scenario.cycles;
  json["stops"] = trajectory.summary().stops;
  json["sticking_fraction"] = trajectory.summary().sticking_fraction;
  json["steps"] = trajectory.summary().steps;
  json["steady"] = Json();
  if (const auto orbit = model::steady_orbit(scenario); orbit && scenario.cycles > 0) {
    constexpr double kRounding = 1e-12;  // of the platform's velocity
    double v = orbit->mean_velocity(scenario.drive.angular_frequency);
    if (v < kRounding * scenario.drive.amplitude * scenario.drive.angular_frequency) v = 0;
    json["steady"] = {{"alpha_rad", v > 0 ? Json(orbit->alpha()) : Json()}, {"v_mm_s", v * 1e3}};
  }
  return json;
}

Columns columns_of(const model::Trajectory& trajectory, int samples_per_cycle) {
  constexpr std::array kNames = {"time_s", "x_mm", "y_mm", "vx_mm_s", "vy_mm_s", "mu"};
  std::array<std::vector<double>, kNames.size()> numbers;
  std::vector<const char*> states;
  const auto count = static_cast<long>(intervals_of(trajectory.scenario(), samples_per_cycle));
  for (long k = 0; k <= count; ++k) {
    const double time = k == count
                            ? trajectory.end_time()
                            : trajectory.end_time() * static_cast<double>(k) / static_cast<double>(count);
    const model::Sample s = trajectory.at(time);
    const Eigen::Vector2d mm = 1e3 * s.position, mm_s = 1e3 * s.velocity;
    const std::array row = {s.time, mm.x(), mm.y(), mm_s.x(), mm_s.y(), s.mu};
    for (std::size_t i = 0; i < row.size(); ++i) numbers[i].push_back(row[i]);
    states.push_back(s.state == model::State::slip ? "slip" : "stick");
  }
  Columns columns;
  for (std::size_t i = 0; i < kNames.size(); ++i) columns.emplace_back(kNames[i], std::move(numbers[i]));
  columns.emplace_back("state", std::move(states));
  return columns;
}

void require_sensible_table(const std::string& name, const model::Scenario& scenario, int samples_per_cycle) {
  constexpr double kBytesPerRow = 120, kLargest = 2e9;
  const double rows = intervals_of(scenario, samples_per_cycle) + 1;
  if (rows * kBytesPerRow < kLargest) return;
  throw InvalidInput(
      "{}: the table would have {:.0f} rows and take about {:.3g} GB, of at most {:.0f} GB: lower --cycles "
      "or --samples-per-cycle",
      name, rows, 1e-9 * rows * kBytesPerRow, 1e-9 * kLargest);
}

namespace {

[[noreturn]] void refuse(const std::string& text) {
  throw UsageError(
      "--over {}: must read NAME=FROM:TO:COUNT, such as phi_rad=0:2pi:73, or NAME=VALUE,VALUE,...", text);
}

/// Of an angle in degrees, too.
void require_values(const std::string& text, const std::string& name, const std::vector<double>& values) {
  if (values.empty()) throw UsageError("--over {}: has no values", text);
  for (const double value : values) {
    if (!std::isfinite(value)) throw UsageError("--over {}: {} is no value", text, value);
    const std::string slip = name.ends_with("_rad") ? angle_slip(value) : "";
    if (!slip.empty()) throw UsageError("--over {}: {} {}", text, name, slip);
  }
}

double value_in(const std::string& text, std::string_view part) {
  const auto value = parse_angle(part);
  if (!value) refuse(text);
  return *value;
}

/// FROM:TO:COUNT.
std::vector<double> range_in(const std::string& text, const std::vector<std::string>& parts) {
  if (parts.size() != 3) refuse(text);
  const double from = value_in(text, parts[0]), to = value_in(text, parts[1]);
  const auto count = parse_number(parts[2]);
  if (!count) refuse(text);
  if (*count < 1 || *count > kMostScenarios || *count != std::floor(*count))
    throw UsageError("--over {}: the count, its last number, must be a whole number, 1 to {:.0f}, not {}",
                     text, kMostScenarios, *count);
  std::vector<double> values(static_cast<std::size_t>(*count), from);
  for (std::size_t k = 1; k < values.size(); ++k)
    values[k] = from + (to - from) * static_cast<double>(k) / (*count - 1);
  return values;
}

}  // namespace

SweepAxis::SweepAxis(std::string name, std::vector<double> values)
    : name_(std::move(name)), text_(name_), values_(std::move(values)) {
  require_values(text_, name_, values_);
}

SweepAxis::SweepAxis(const std::string& text) : text_(text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos) refuse(text);
  name_ = text.substr(0, equals);
  const std::string_view given = std::string_view(text).substr(equals + 1);
  const std::vector<std::string> list = parts_of(given, ',');
  if (list.size() == 1 || given.find(':') != given.npos)
    values_ = range_in(text, parts_of(given, ':'));
  else
    for (const std::string& part : list) values_.push_back(value_in(text, part));
  require_values(text, name_, values_);
}

std::vector<SweepAxis> sweep_axes(const std::vector<std::string>& texts) {
  std::vector<SweepAxis> axes;
  for (const auto& text : texts) axes.emplace_back(text);
  if (axes.empty() || axes.size() > 2)
    throw UsageError(
        "sweep needs one or two --over NAME=FROM:TO:COUNT (or `over` in [sweep] of the scenario)");
  if (axes.size() == 1) return axes;
  if (axes[0].name() == axes[1].name())
    throw UsageError("--over names {} twice; give another parameter for the second axis", axes[0].name());
  if (meaning_of(axes[0].name()) == meaning_of(axes[1].name()))
    throw UsageError("--over names {} and {}, which mean the same; give one of them", axes[0].name(),
                     axes[1].name());
  const double total = static_cast<double>(axes[0].count()) * static_cast<double>(axes[1].count());
  if (total > kMostScenarios)
    throw UsageError(
        "--over {} --over {}: {:.0f} scenarios, at most {:.0f} are solved at once; lower the counts",
        axes[0].text(), axes[1].text(), total, kMostScenarios);
  return axes;
}

Sweep::Sweep(ScenarioFile base, std::vector<SweepAxis> axes)
    : base_(std::move(base)), axes_(std::move(axes)) {
  base_.over.clear();  // copied with each scenario
  for (const SweepAxis& axis : axes_) count_ *= axis.count();
}

double Sweep::value(std::size_t index, std::size_t axis) const {
  const std::size_t inner = axes_.back().count();
  return axes_[axis].value(axis + 1 == axes_.size() ? index % inner : index / inner);
}

model::Scenario Sweep::scenario(std::size_t index) const {
  ScenarioFile file = base_;
  for (std::size_t axis = 0; axis < axes_.size(); ++axis)
    set_scenario_parameter(file, axes_[axis].name(), value(index, axis));
  file.settle();
  return file.scenario;
}

namespace {

/// The corners decide: each parameter's range is an interval.
void require_valid(const Sweep& sweep) {
  const std::size_t inner = sweep.axes().back().count();
  for (const std::size_t index : {std::size_t{0}, inner - 1, sweep.count() - inner, sweep.count() - 1}) try {
      sweep.scenario(index).validate();
    } catch (const model::InvalidParameter& error) {
      std::string axes;
      for (const SweepAxis& axis : sweep.axes())
        axes += fmt::format("{}--over {}", axes.empty() ? "" : " ", axis.text());
      throw InvalidInput("{}: {}", axes, error.what());
    }
}

/// alpha (NaN where nothing has moved) and v.
void put(const Eigen::Vector2d& moved, double time, double& alpha, double& v) {
  if (moved.norm() > 0) alpha = model::displacement_angle(moved);
  v = 1e3 * moved.norm() / time;
}

}  // namespace

SweptModel solve(const Sweep& sweep, const Context& context) {
  require_valid(sweep);
  const std::size_t count = sweep.count();
  const std::vector<double> none(count, std::numeric_limits<double>::quiet_NaN());
  SweptModel solved{none, none, none, none};
  Progress progress("sweep", context);
  std::atomic<std::int64_t> done = 0;
  model::IntegrationOptions ends_only;
  ends_only.dense = false;
  ends_only.tolerance = 1e-14;  // 1e-13 of the way
  parallel_for(count, threads_to_use(context), [&](std::size_t k) {
    const model::Scenario scenario = sweep.scenario(k);
    const model::Trajectory run = model::integrate(scenario, ends_only);
    put(run.end().position, run.end_time(), solved.alpha_rad[k], solved.v_mm_s[k]);
    try {
      if (const auto orbit = model::steady_orbit(scenario))
        put(orbit->drift, 2 * std::numbers::pi / scenario.drive.angular_frequency, solved.steady_alpha_rad[k],
            solved.steady_v_mm_s[k]);
    } catch (const model::StepLimitExceeded&) {  // friction next to nothing
    }
    progress.update(++done, static_cast<std::int64_t>(count));
  });
  return solved;
}

}  // namespace tribotrack::apps
