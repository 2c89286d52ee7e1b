#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/files/campaign/keys.h"
#include "apps/program/errors.h"
#include "fit/conditions.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;
using fit::FitParameter;

const std::vector<FitParameter>& fit_parameters() {
  static const std::vector<FitParameter> parameters = {
      FitParameter::mu1,   FitParameter::mu2,       FitParameter::lag,
      FitParameter::delay, FitParameter::amplitude, FitParameter::angular_frequency,
      FitParameter::scale, FitParameter::tilt_x,    FitParameter::tilt_y};
  return parameters;
}

Kind kind_of(FitParameter parameter) {
  switch (parameter) {
    case FitParameter::mu1:
    case FitParameter::mu2:
      return Kind::not_negative;
    case FitParameter::amplitude:
    case FitParameter::angular_frequency:
    case FitParameter::scale:
      return Kind::above_zero;
    default:
      return std::string_view(fit::to_string(parameter)).ends_with("_rad") ? Kind::angle : Kind::number;
  }
}

std::optional<FitParameter> fit_parameter_named(const std::string& name) {
  for (const FitParameter parameter : fit_parameters())
    if (name == fit::to_string(parameter)) return parameter;
  return std::nullopt;
}

double si_per_campaign_unit(FitParameter parameter) {
  return parameter == FitParameter::amplitude ? 1e-3 : 1;
}

namespace {

FitParameter require_fit_parameter(const StrictTable& table, std::string_view key, const std::string& name) {
  if (const auto parameter = fit_parameter_named(name)) return *parameter;
  std::vector<std::string> names;
  for (const FitParameter known : fit_parameters()) names.emplace_back(fit::to_string(known));
  const std::string near = nearest_word(name, names);
  table.fail(key, fmt::format("names \"{}\", which cannot be fitted; {}", name,
                              near.empty() ? fmt::format("these can: {}", fmt::join(names, ", "))
                                           : fmt::format("did you mean \"{}\"?", near)));
}

/// A table of values by parameter name.
std::map<FitParameter, double> read_values(StrictTable table, const std::vector<FitParameter>& allowed) {
  std::map<FitParameter, double> values;
  for (const FitParameter parameter : allowed) {
    if (const auto value = read_number(table, kind_of(parameter), fit::to_string(parameter)))
      values[parameter] = *value;
  }
  table.finish();
  return values;
}

void read_priors(StrictTable prior, FitSection& fit) {
  for (const std::string& name : prior.keys()) {
    const FitParameter parameter = require_fit_parameter(prior, name, name);
    if (std::ranges::count(fit.parameters, parameter) == 0)
      prior.fail(name,
                 "is not among `parameters`, and a prior of what is not fitted has no effect: add it there, "
                 "or give the value with its sd where it belongs");
    auto entry = prior.table(name);
    const auto mean = read_number(*entry, kind_of(parameter), "mean");
    const auto sd = entry->positive("sd");
    entry->finish();
    if (!mean || !sd) prior.fail(name, "needs a mean and an sd: { mean = 0.1, sd = 0.01 }");
    fit.prior[parameter] = {*mean, *sd};
  }
  prior.finish();
}

void read_parameters(StrictTable& table, FitSection& fit, const fs::path&) {
  const auto names = table.texts("parameters");
  if (!names) return;
  fit.parameters_given = true;
  fit.parameters.clear();
  for (const auto& name : *names) {
    const FitParameter parameter = require_fit_parameter(table, "parameters", name);
    if (std::ranges::count(fit.parameters, parameter) > 0)
      table.fail("parameters", fmt::format("names \"{}\" twice", name));
    fit.parameters.push_back(parameter);
  }
  if (fit.parameters.empty())
    table.fail("parameters", "is empty; name what is to be fitted, such as [\"mu1\"]");
}

Json written_parameters(const FitSection& fit) {
  Json names = Json::array();
  for (const FitParameter parameter : fit.parameters) names.push_back(fit::to_string(parameter));
  return names;
}

void read_exact(StrictTable& table, FitSection& fit, const fs::path&) {
  if (!table.is_list("exact")) {
    fit.exact.all = table.boolean("exact").value_or(false);
    return;
  }
  std::map<std::string, std::string> known;  // by every name of it the key of what may have an sd
  for (const CampaignSection& section : campaign_sections())
    for (const KeyFacts& key : section.keys) {
      if (std::ranges::count(section.keys, key.name + "_sd", &KeyFacts::name) == 0) continue;
      known[key.name] = key.name;
      for (const OtherName& other : other_names(key.name)) known[other.name] = key.name;
    }
  const std::string law = fit::to_string(fit::Source::friction_law);
  known[law] = law;
  std::vector<std::string> names;
  for (const auto& [name, key] : known) names.push_back(name);
  const std::vector<std::string> given = table.texts("exact").value();
  for (const std::string& name : given) {
    const std::string near = nearest_word(name, names);
    if (!known.contains(name))
      table.fail("exact", fmt::format("names \"{}\", which is no quantity with an sd; {}", name,
                                      near.empty() ? fmt::format("these are: {}", fmt::join(names, ", "))
                                                   : fmt::format("did you mean \"{}\"?", near)));
    fit.exact.keys.push_back(known.at(name));
  }
}

Json written_exact(const FitSection& fit) {
  return fit.exact.all ? Json(true) : Json(fit.exact.keys);
}

}  // namespace

const Keys<FitSection>& fit_keys() {
  using F = FitSection;
  static const Keys<F> keys = {
      {"parameters", Kind::texts, Own<F>{read_parameters, written_parameters},
       "[\"mu1\", \"mu2\", \"phase_lag_rad\"]",
       "these (free slides alone: mu1), delay_s, amplitude_mm, angular_frequency_rad_s, mm_per_px, "
       "tilt_x_rad, tilt_y_rad"},
      {"data", Kind::one_of({"summary", "trajectory"}), at<&F::trajectory>, "\"summary\"",
       "each run's displacement (alpha, v); \"trajectory\": every tracked point"},
      {"exact", Kind::true_or_texts, Own<F>{read_exact, written_exact}, "[\"amplitude_mm\"]",
       "what is known without an error although it has no sd (frequency_hz, tilt_x_rad, start_phase_rad, "
       "friction_law, ...); true: everything, also what is not given"},
      {"hold_out", Kind::texts, at<&F::hold_out>, "[\"run name\"]",
       "driven runs that are not fitted, but predicted by the fit"},
      {"start", Kind::one_of(kStarts), at<&F::start>, "\"rest\"",
       "how runs start at their first analysed frame: rest, circling or steady"},
      {"cycles", Kind::wholes(1, 1'000'000), at<&F::cycles>, "20",
       "whole cycles alpha and v are measured over, at most"},
  };
  return keys;
}

const Keys<ScopeSection>& scope_keys() {
  using S = ScopeSection;
  static const Keys<S> keys = {
      {"sensor_channel", Kind::wholes(0, 4), at<&S::sensor_channel>, "1",
       "reference pulses of the platform's phase sensor; 0: none"},
      {"actuator_channel", Kind::wholes(0, 4), at<&S::actuator_channel>, "2",
       "the bursts that drive the actuator; 0: none"},
      {"carrier_hz", Kind::above_zero, at<&S::carrier_hz>, "5890", "of the bursts"},
      {"sensor_delay_s", Kind::number, at<&S::sensor_delay_s>, "0.0",
       "by which the sensor's filter makes its pulse late"},
      {"sensor_delay_sd_s", Kind::not_negative, at<&S::sensor_delay_sd_s>, "0.00001"},
      {"tie", Kind::one_of({"sensor", "trigger", "lamp"}), at<&S::tie>, "\"sensor\"",
       "phi counts from the sensor; \"trigger\": both zero at one trigger; \"lamp\": phi from gate_px"},
      {"trigger_time_s", Kind::number, at<&S::trigger_time_s>, "0.0",
       "the trigger in the recording's time; a .cine holds it itself"},
      {"tie_sd_s", Kind::not_negative, at<&S::tie_sd_s>, "0.00001", "of that tie"},
  };
  return keys;
}

bool Exact::holds(std::string_view key) const {
  return all || std::ranges::count(keys, key) > 0;
}

double default_sd(const Exact& exact, std::string_view key, double value, const Digits& digits) {
  struct Trade {
    std::string_view key;
    double absolute, relative;
  };
  constexpr double degree = std::numbers::pi / 180;
  constexpr double kCaliper = 0.02, kLevel = 2e-3;
  constexpr Trade kTrade[] = {{"amplitude_mm", 0, 0.005},
                              {"amplitude_y_mm", 0, 0.005},
                              {"amplitude_ratio", 0, 0.01},
                              {"angular_frequency_rad_s", 0, 1e-4},
                              {"phase_shift_rad", degree, 0},
                              {"tilt_x_rad", kLevel, 0},
                              {"tilt_y_rad", kLevel, 0},
                              {"slope_rad", 0.1 * degree, 0},
                              {"diameter_mm", kCaliper, 0},
                              {"tag_mm", kCaliper, 0},
                              {"mm_per_px", 0, 0},
                              {"phi_rad", 0, 0},
                              {"dtau_rad", 0, 0},
                              {"start_phase_rad", 0, 0},
                              {"phase_at_zero_rad", 0, 0}};
  const auto* trade = std::ranges::find(kTrade, key, &Trade::key);
  if (trade == std::end(kTrade) || exact.holds(key)) return 0;
  const auto digit = digits.find(key);
  // No instrument of the trade errs by more than a twentieth: a value that small is a slip.
  const double absolute =
      trade->absolute == kCaliper ? std::min(kCaliper, 0.05 * std::abs(value)) : trade->absolute;
  return std::max({digit == digits.end() ? 0 : digit->second, absolute, trade->relative * std::abs(value)});
}

FitSection read_fit(StrictTable& table) {
  if (table.is_table("start")) table.fail("start", kGuessHint);
  FitSection fit;
  read_keys(table, fit_keys(), fit);
  if (auto guesses = table.table("guess")) fit.guess = read_values(*guesses, fit_parameters());
  if (auto fixed = table.table("fixed"))
    fit.fixed =
        read_values(*fixed, {FitParameter::mu1, FitParameter::mu2, FitParameter::lag, FitParameter::delay});
  for (const auto& [parameter, value] : fit.fixed)
    if (std::ranges::count(fit.parameters, parameter) > 0)
      table.fail("fixed",
                 fmt::format("holds {}, which `parameters` lists as fitted; take it out of one of them",
                             fit::to_string(parameter)));
  if (auto prior = table.table("prior")) read_priors(*prior, fit);
  table.finish();
  return fit;
}

ScopeSection read_scope(StrictTable& table) {
  ScopeSection scope;
  read_keys(table, scope_keys(), scope);
  if (scope.sensor_channel != 0 && scope.sensor_channel == scope.actuator_channel) {
    const bool of_sensor = table.has("sensor_channel");
    table.fail(
        of_sensor ? "sensor_channel" : "actuator_channel",
        fmt::format(
            "is {}, and so is `{}`: one channel holds either the sensor's pulses or the actuator's bursts",
            scope.sensor_channel, of_sensor ? "actuator_channel" : "sensor_channel"));
  }
  table.finish();
  return scope;
}

}  // namespace tribotrack::apps
