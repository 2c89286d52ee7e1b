#include "apps/files/campaign/fit_section.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "apps/program/errors.h"

namespace tribotrack::apps {

using fit::FitParameter;

namespace {

const std::vector<FitParameter> kFitParameters = {
    FitParameter::mu1,   FitParameter::mu2,       FitParameter::lag,
    FitParameter::delay, FitParameter::amplitude, FitParameter::angular_frequency,
    FitParameter::scale, FitParameter::tilt_x,    FitParameter::tilt_y};

std::vector<std::string> fit_parameter_names() {
  std::vector<std::string> names;
  for (const FitParameter parameter : kFitParameters) names.emplace_back(fit::to_string(parameter));
  return names;
}

FitParameter require_fit_parameter(const StrictTable& table, std::string_view key, const std::string& name) {
  if (const auto parameter = fit_parameter_named(name)) return *parameter;
  const std::string near = nearest_word(name, fit_parameter_names());
  table.fail(key,
             fmt::format("names \"{}\", which cannot be fitted; {}", name,
                         near.empty() ? fmt::format("these can: {}", fmt::join(fit_parameter_names(), ", "))
                                      : fmt::format("did you mean \"{}\"?", near)));
}

/// One value of a parameter, as [fit.fixed], [fit.guess] and [fit.prior] give it. Angles may be texts.
std::optional<double> read_value(StrictTable& table, const char* key, FitParameter parameter) {
  const bool angle = std::string_view(fit::to_string(parameter)).ends_with("_rad");
  return angle ? table.angle(key) : table.number(key);
}

/// `place`: the key of `table` that an error is said of.
void require_in_range(const StrictTable& table, const char* place, FitParameter parameter, double value) {
  switch (parameter) {
    case FitParameter::mu1:
    case FitParameter::mu2:
      if (value < 0) table.fail(place, fmt::format("must be 0 or more, not {}", value));
      break;
    case FitParameter::amplitude:
    case FitParameter::angular_frequency:
    case FitParameter::scale:
      if (!(value > 0)) table.fail(place, fmt::format("must be greater than 0, not {}", value));
      break;
    default:
      break;
  }
}

/// A table of values by parameter name.
std::map<FitParameter, double> read_values(StrictTable table, const std::vector<FitParameter>& allowed) {
  std::map<FitParameter, double> values;
  for (const FitParameter parameter : allowed) {
    const char* name = fit::to_string(parameter);
    if (const auto value = read_value(table, name, parameter)) {
      require_in_range(table, name, parameter, *value);
      values[parameter] = *value;
    }
  }
  table.finish();
  return values;
}

}  // namespace

std::optional<FitParameter> fit_parameter_named(const std::string& name) {
  for (const FitParameter parameter : kFitParameters)
    if (name == fit::to_string(parameter)) return parameter;
  return std::nullopt;
}

double si_per_campaign_unit(FitParameter parameter) {
  return parameter == FitParameter::amplitude ? 1e-3 : 1;
}

ScopeSection read_scope(StrictTable& table) {
  ScopeSection scope;
  const auto channel = [&](const char* key, int fallback) {
    const auto value = table.integer(key).value_or(fallback);
    if (value < 0 || value > 4)
      table.fail(key, fmt::format("must be 1 to 4, the file's first to fourth channel, or 0 for none, not {}",
                                  value));
    return static_cast<int>(value);
  };
  scope.sensor_channel = channel("sensor_channel", scope.sensor_channel);
  scope.actuator_channel = channel("actuator_channel", scope.actuator_channel);
  if (scope.sensor_channel != 0 && scope.sensor_channel == scope.actuator_channel)
    table.fail(
        table.has("sensor_channel") ? "sensor_channel" : "actuator_channel",
        fmt::format("is {}, and so is `{}`: one channel holds either the sensor's pulses or the actuator's "
                    "bursts",
                    scope.sensor_channel,
                    table.has("sensor_channel") ? "actuator_channel" : "sensor_channel"));
  scope.carrier_hz = table.positive("carrier_hz").value_or(scope.carrier_hz);
  scope.sensor_delay_s = table.number("sensor_delay_s").value_or(0);
  scope.sensor_delay_sd_s = table.not_negative("sensor_delay_sd_s").value_or(0);
  constexpr std::array<const char*, 3> ties = {"sensor", "trigger", "lamp"};
  scope.tie = ties[table.choice("tie", {"sensor", "trigger", "lamp"}).value_or(0)];
  scope.trigger_time_s = table.number("trigger_time_s");
  scope.tie_sd_s = table.not_negative("tie_sd_s").value_or(0);
  table.finish();
  return scope;
}

int read_cycles(StrictTable& table, int fallback) {
  const auto cycles = table.integer("cycles").value_or(fallback);
  if (cycles < 1 || cycles > 1'000'000)
    table.fail("cycles", fmt::format("must be between 1 and 1000000, not {}", cycles));
  return static_cast<int>(cycles);
}

model::Start read_start(StrictTable& table, model::Start fallback) {
  const auto choice = table.choice("start", {"rest", "circling", "steady"});
  return choice ? static_cast<model::Start>(*choice) : fallback;
}

FitSection read_fit(StrictTable& table, FitDefaults& defaults) {
  FitSection section;
  if (const auto names = table.texts("parameters")) {
    section.parameters_given = true;
    section.parameters.clear();
    for (const auto& name : *names) {
      const FitParameter parameter = require_fit_parameter(table, "parameters", name);
      if (std::count(section.parameters.begin(), section.parameters.end(), parameter) > 0)
        table.fail("parameters", fmt::format("names \"{}\" twice", name));
      section.parameters.push_back(parameter);
    }
    if (section.parameters.empty())
      table.fail("parameters", "is empty; name what is to be fitted, such as [\"mu1\"]");
  }
  section.trajectory = table.choice("data", {"summary", "trajectory"}).value_or(0) == 1;
  if (table.is_table("start")) table.fail("start", kGuessHint);
  defaults.start = read_start(table, defaults.start);
  if (auto guesses = table.table("guess")) section.guess = read_values(*guesses, kFitParameters);
  defaults.cycles = read_cycles(table, defaults.cycles);
  if (auto fixed = table.table("fixed"))
    section.fixed =
        read_values(*fixed, {FitParameter::mu1, FitParameter::mu2, FitParameter::lag, FitParameter::delay});
  for (const auto& [parameter, value] : section.fixed)
    if (std::count(section.parameters.begin(), section.parameters.end(), parameter) > 0)
      table.fail("fixed",
                 fmt::format("holds {}, which `parameters` lists as fitted; take it out of one of them",
                             fit::to_string(parameter)));
  if (auto prior = table.table("prior")) {
    for (const std::string& name : prior->keys()) {
      const FitParameter parameter = require_fit_parameter(*prior, name, name);
      if (std::count(section.parameters.begin(), section.parameters.end(), parameter) == 0)
        prior->fail(name,
                    "is not among `parameters`, and a prior of what is not fitted has no effect: add it "
                    "there, or give the value with its sd where it belongs");
      auto entry = prior->table(name);
      const auto mean = read_value(*entry, "mean", parameter);
      const auto sd = entry->positive("sd");
      entry->finish();
      if (!mean || !sd) prior->fail(name, "needs a mean and an sd: { mean = 0.1, sd = 0.01 }");
      require_in_range(*prior, name.c_str(), parameter, *mean);
      section.prior[parameter] = {*mean, *sd};
    }
    prior->finish();
  }
  table.finish();
  return section;
}

}  // namespace tribotrack::apps
