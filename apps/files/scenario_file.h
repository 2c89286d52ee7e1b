// SCENARIO.toml, and how it is told from the other TOML files that commands read.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/files/keys.h"
#include "apps/text/json.h"
#include "apps/text/strict_toml.h"
#include "model/scenario.h"

namespace tribotrack::apps {

// The TOML files that the commands read, told from each other by their tables.

enum class TomlKind { campaign, scenario, scene };

/// Throws InvalidInput where the file is of another kind than `wanted`, naming the command that takes it.
void require_kind(const StrictTable& top, TomlKind wanted, const std::string& file);

// SCENARIO.toml: one run of the friction model, and what to sweep it over.

/// [platform] of a campaign. SI. Lengths and frequency may be left to be measured; a value without a standard
/// deviation has its default_sd().
struct PlatformSection {
  std::optional<double> amplitude, amplitude_y;  ///< m
  std::optional<double> angular_frequency;       ///< rad/s
  std::optional<double> phase_shift;             ///< rad
  double gravity = 9.81;
  double tilt_x = 0, tilt_y = 0;
  std::optional<double> amplitude_sd, amplitude_y_sd, angular_frequency_sd, phase_shift_sd, gravity_sd,
      tilt_x_sd, tilt_y_sd;
  Digits digits = {};  ///< of what is given
};
PlatformSection read_platform(StrictTable& table);

/// One run of the model, and [sweep] over = ["NAME=FROM:TO:COUNT", ...].
struct ScenarioFile {
  model::Scenario scenario;
  std::optional<double> mu1_over_mu2;  ///< ties mu2 to mu1, also in sweeps
  int samples_per_cycle = 100;
  std::vector<std::string> over;
  /// Applies the tie.
  void settle();
};
ScenarioFile read_scenario_file(const std::filesystem::path& file);
/// The same tables out of a larger file; its other keys are left to the caller.
ScenarioFile read_scenario_tables(StrictTable& top);

/// What a scenario is made of: keys of [platform], [friction] and [run], flags of `simulate`, names of sweeps
/// and of results. other_names() of them are taken, too.
const Keys<ScenarioFile>& scenario_parameters();
std::vector<std::string> scenario_parameter_names();
/// What holds without it; nothing where it follows from others.
std::optional<double> default_of(const Key<ScenarioFile>& parameter);

/// `name`: of a scenario_parameter, or another of its names. Throws UsageError for any other.
void set_scenario_parameter(ScenarioFile& file, const std::string& name, double value);
/// The name of the parameter that is meant; empty for none.
std::string scenario_parameter_named(const std::string& name);

/// In the order of model::Start.
inline const std::vector<std::string> kStarts = {"rest", "circling", "steady"};
model::Start parse_start(const std::string& word);
Json json_of(const model::Scenario& scenario);

}  // namespace tribotrack::apps
