#include "apps/files/scenario_file.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "apps/files/campaign/keys.h"
#include "apps/program/errors.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

namespace {

/// nullopt where its tables do not tell.
std::optional<TomlKind> kind_of(const StrictTable& top) {
  if (top.has("shot") || top.has("video") || top.has("disc")) return TomlKind::scene;
  if (top.is_list("run") || top.has("fit") || top.has("data")) return TomlKind::campaign;
  if (top.is_table("run") || top.has("friction") || top.has("sweep")) return TomlKind::scenario;
  return std::nullopt;
}

/// What a file is, and the command that takes it; in the order of TomlKind.
constexpr std::pair<const char*, const char*> kKinds[] = {
    {"campaign", "run {} -o DIR"}, {"scenario", "simulate {}"}, {"scene", "synth {} -o VIDEO"}};

}  // namespace

void require_kind(const StrictTable& top, TomlKind wanted, const std::string& file) {
  const auto kind = kind_of(top);
  if (!kind || *kind == wanted) return;
  const auto& [name, command] = kKinds[static_cast<int>(*kind)];
  throw InvalidInput("{}: is a {}, not a {}; `tribotrack {}` takes it", file, name,
                     kKinds[static_cast<int>(wanted)].first, fmt::format(fmt::runtime(command), file));
}

namespace {

/// A platform tilted by more is no platform.
constexpr double kSteepest = std::numbers::pi / 4;

}  // namespace

PlatformSection read_platform(StrictTable& table) {
  PlatformSection platform;
  read_keys(table, platform_keys(), platform);
  for (const auto& [key, tilt] :
       {std::pair{"tilt_x_rad", platform.tilt_x}, std::pair{"tilt_y_rad", platform.tilt_y}})
    if (std::abs(tilt) > kSteepest)
      table.fail(key, fmt::format("must lie within pi/4, not {0}: degrees? write \"{0}deg\"", tilt));
  table.finish();
  return platform;
}

void ScenarioFile::settle() {
  for (const auto& [name, tilt] :
       {std::pair{"tilt_x_rad", scenario.drive.tilt_x}, std::pair{"tilt_y_rad", scenario.drive.tilt_y}})
    if (std::abs(tilt) > kSteepest)
      throw InvalidInput("{} = {} is out of range: it must lie within pi/4", name, tilt);
  if (!mu1_over_mu2) return;
  if (!(*mu1_over_mu2 > 0)) throw InvalidInput("mu1_over_mu2 must be greater than 0, not {}", *mu1_over_mu2);
  scenario.friction.reduced = scenario.friction.nominal / *mu1_over_mu2;
}

ScenarioFile read_scenario_file(const std::filesystem::path& path) {
  StrictTable top = StrictTable::read(path);
  require_kind(top, TomlKind::scenario, path.string());
  ScenarioFile file = read_scenario_tables(top);
  top.finish();
  return file;
}

namespace {

template <int axis>
Value velocity(ScenarioFile& file) {
  return Milli<double>{&file.scenario.initial_velocity[axis]};
}

constexpr auto scenario = &ScenarioFile::scenario;
using S = model::Scenario;

const Keys<ScenarioFile> kPlatform = {
    {"amplitude_mm", Kind::not_negative, milli<scenario, &S::drive, &model::Drive::amplitude>, "",
     "Platform amplitude A (and A_y)"},
    {"amplitude_y_mm", Kind::not_negative, milli<scenario, &S::drive, &model::Drive::amplitude_y>, "",
     "Platform amplitude along y, if different"},
    {"omega_rad_s", Kind::above_zero, at<scenario, &S::drive, &model::Drive::angular_frequency>, "",
     "Angular frequency w of the platform"},
    {"epsilon_rad", Kind::angle, at<scenario, &S::drive, &model::Drive::phase_shift>, "",
     "Phase shift epsilon between the axes (pi/2: a circle, clockwise with y up)"},
    {"gravity_m_s2", Kind::above_zero, at<scenario, &S::drive, &model::Drive::gravity>, "", "Gravity g"},
    {"tilt_x_rad", Kind::angle, at<scenario, &S::drive, &model::Drive::tilt_x>, "",
     "Slope of the platform towards +x (right)"},
    {"tilt_y_rad", Kind::angle, at<scenario, &S::drive, &model::Drive::tilt_y>, "",
     "Slope of the platform towards +y (up)"},
};

const Keys<ScenarioFile> kFriction = {
    {"mu1", Kind::not_negative, at<scenario, &S::friction, &model::Friction::nominal>, "",
     "Nominal friction coefficient mu1"},
    {"mu2", Kind::not_negative, at<scenario, &S::friction, &model::Friction::reduced>, "",
     "Reduced friction coefficient mu2, inside the pulse"},
    {"mu1_over_mu2", Kind::above_zero, at<&ScenarioFile::mu1_over_mu2>, "",
     "Give mu2 as this ratio mu1/mu2 instead"},
    {"phi_rad", Kind::angle, at<scenario, &S::friction, &model::Friction::phase>, "",
     "Phase phi at which the pulse of reduced friction opens"},
    {"dtau_rad", Kind::angle, at<scenario, &S::friction, &model::Friction::pulse_width>, "",
     "Width dtau of the pulse, 0 .. 2pi"},
    {"lag_rad", Kind::angle, at<scenario, &S::friction, &model::Friction::lag>, "",
     "Phase lag of the actuator, added to phi"},
};

const Keys<ScenarioFile> kRun = {
    {"start_phase_rad", Kind::angle, at<scenario, &S::start_phase>, "", "Platform phase wt at the start"},
    {"velocity_x_mm_s", Kind::number, velocity<0>, "",
     "Initial velocity relative to the platform (start = rest)"},
    {"velocity_y_mm_s", Kind::number, velocity<1>, "",
     "Initial velocity relative to the platform (start = rest)"},
    {"cycles", Kind::above_zero, at<scenario, &S::cycles>, "", "Platform cycles to simulate"},
    {"spin_rad_s", Kind::number, at<scenario, &S::spin, &model::Spin::rate>, "",
     "Spin of a disc that slides freely"},
    {"radius_mm", Kind::above_zero, milli<scenario, &S::spin, &model::Spin::radius>, "", "Its radius"},
    {"spin_inertia", Kind::above_zero, at<scenario, &S::spin, &model::Spin::inertia>, "",
     "Its moment of inertia over m r^2"},
};

}  // namespace

const Keys<ScenarioFile>& scenario_parameters() {
  static const Keys<ScenarioFile> all = [] {
    Keys<ScenarioFile> keys = kPlatform;
    for (const auto& more : {kFriction, kRun}) keys.insert(keys.end(), more.begin(), more.end());
    return keys;
  }();
  return all;
}

ScenarioFile read_scenario_tables(StrictTable& top) {
  ScenarioFile file;
  if (auto table = top.table("platform")) {
    model::Drive& drive = file.scenario.drive;
    read_keys(*table, kPlatform, file);
    if (!table->has("amplitude_y_mm")) drive.amplitude_y = drive.amplitude;
    table->finish();
  }
  if (auto table = top.table("friction")) {
    read_keys(*table, kFriction, file);
    if (table->has("mu2") && file.mu1_over_mu2)
      table->fail("mu2", "and `mu1_over_mu2` mean the same; give one of them");
    table->finish();
  }
  if (auto table = top.table("run")) {
    read_keys(*table, kRun, file);
    if (const auto start = table->choice("start", kStarts))
      file.scenario.start = static_cast<model::Start>(*start);
    read_value(*table, {"samples_per_cycle", Kind::wholes(1, 1'000'000)}, {}, &file.samples_per_cycle);
    table->finish();
  }
  if (auto table = top.table("sweep")) {
    file.over = table->texts("over").value_or(std::vector<std::string>{});
    table->finish();
  }
  file.settle();
  return file;
}

namespace {

struct Named {
  const Key<ScenarioFile>* parameter = nullptr;
  double factor = 1;
};

Named named(std::string_view name) {
  for (const Key<ScenarioFile>& key : scenario_parameters())
    if (key.name == name) return {&key};
  for (const Key<ScenarioFile>& key : scenario_parameters())
    for (const OtherName& other : other_names(key.name))
      if (other.name == name) return {&key, other.factor};
  return {};
}

}  // namespace

std::vector<std::string> scenario_parameter_names() {
  std::vector<std::string> names;
  for (const KeyFacts& key : scenario_parameters()) names.push_back(key.name);
  return names;
}

std::string scenario_parameter_named(const std::string& name) {
  const Named found = named(name);
  return found.parameter != nullptr ? found.parameter->name : "";
}

void set_scenario_parameter(ScenarioFile& file, const std::string& name, double value) {
  if (const auto [parameter, factor] = named(name); parameter != nullptr) {
    set_value(parameter->value(file).value(), value * factor);
    if (parameter->name == "amplitude_mm") file.scenario.drive.amplitude_y = file.scenario.drive.amplitude;
    if (parameter->name == "mu2") file.mu1_over_mu2.reset();
    return;
  }
  const std::vector<std::string> names = scenario_parameter_names();
  const std::string near = nearest_word(name, names);
  throw UsageError("\"{}\" is not a parameter of a scenario{}; known: {}", name,
                   near.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", near), fmt::join(names, ", "));
}

model::Start parse_start(const std::string& word) {
  for (std::size_t i = 0; i < kStarts.size(); ++i)
    if (kStarts[i] == word) return static_cast<model::Start>(i);
  throw UsageError("the start must be one of {}, not \"{}\"", fmt::join(kStarts, ", "), word);
}

Json json_of(const model::Scenario& scenario) {
  Json json;
  const Json values = written(scenario_parameters(), ScenarioFile{scenario, {}, 0, {}});
  for (const auto& [name, value] : values.items()) {
    if (name == "mu1_over_mu2" ||
        (scenario.spin.rate == 0 && (name.starts_with("spin") || name == "radius_mm")))
      continue;
    if (name == "start_phase_rad") json["start"] = model::to_string(scenario.start);
    json[name] = value;
  }
  return json;
}

std::optional<double> default_of(const Key<ScenarioFile>& parameter) {
  const Json defaults = json_of(model::Scenario());
  if (parameter.name == "amplitude_y_mm" || !defaults.contains(parameter.name)) return std::nullopt;
  return defaults[parameter.name].get<double>();
}

}  // namespace tribotrack::apps
