#include "apps/files/scenario_file.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <optional>

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

const char* name_of(TomlKind kind) {
  return kind == TomlKind::campaign ? "campaign" : kind == TomlKind::scenario ? "scenario" : "scene";
}

std::string command_for(TomlKind kind, const std::string& file) {
  switch (kind) {
    case TomlKind::campaign:
      return fmt::format("`tribotrack run {} -o DIR` takes it", file);
    case TomlKind::scenario:
      return fmt::format("`tribotrack simulate {}` takes it", file);
    case TomlKind::scene:
      break;
  }
  return fmt::format("`tribotrack synth {} -o VIDEO` takes it", file);
}

}  // namespace

void require_kind(const StrictTable& top, TomlKind wanted, const std::string& file) {
  const auto kind = kind_of(top);
  if (kind && *kind != wanted)
    throw InvalidInput(fmt::format("{}: is a {}, not a {}; {}", file, name_of(*kind), name_of(wanted),
                                   command_for(*kind, file)));
}

namespace {

const std::vector<std::string> kStarts = {"rest", "circling", "steady"};

using Setter = std::function<void(ScenarioFile&, double)>;

const std::map<std::string, Setter>& setters() {
  static const std::map<std::string, Setter> table = {
      {"mu1", [](ScenarioFile& f, double v) { f.scenario.friction.nominal = v; }},
      {"mu2",
       [](ScenarioFile& f, double v) {
         f.scenario.friction.reduced = v;
         f.mu1_over_mu2.reset();
       }},
      {"mu1_over_mu2", [](ScenarioFile& f, double v) { f.mu1_over_mu2 = v; }},
      {"phi_rad", [](ScenarioFile& f, double v) { f.scenario.friction.phase = v; }},
      {"dtau_rad", [](ScenarioFile& f, double v) { f.scenario.friction.pulse_width = v; }},
      {"lag_rad", [](ScenarioFile& f, double v) { f.scenario.friction.lag = v; }},
      {"amplitude_mm",
       [](ScenarioFile& f, double v) {
         f.scenario.drive.amplitude = f.scenario.drive.amplitude_y = v * 1e-3;
       }},
      {"amplitude_y_mm", [](ScenarioFile& f, double v) { f.scenario.drive.amplitude_y = v * 1e-3; }},
      {"omega_rad_s", [](ScenarioFile& f, double v) { f.scenario.drive.angular_frequency = v; }},
      {"epsilon_rad", [](ScenarioFile& f, double v) { f.scenario.drive.phase_shift = v; }},
      {"gravity_m_s2", [](ScenarioFile& f, double v) { f.scenario.drive.gravity = v; }},
      {"tilt_x_rad", [](ScenarioFile& f, double v) { f.scenario.drive.tilt_x = v; }},
      {"tilt_y_rad", [](ScenarioFile& f, double v) { f.scenario.drive.tilt_y = v; }},
      {"velocity_x_mm_s", [](ScenarioFile& f, double v) { f.scenario.initial_velocity.x() = v * 1e-3; }},
      {"velocity_y_mm_s", [](ScenarioFile& f, double v) { f.scenario.initial_velocity.y() = v * 1e-3; }},
      {"spin_rad_s", [](ScenarioFile& f, double v) { f.scenario.spin.rate = v; }},
      {"radius_mm", [](ScenarioFile& f, double v) { f.scenario.spin.radius = v * 1e-3; }},
      {"spin_inertia", [](ScenarioFile& f, double v) { f.scenario.spin.inertia = v; }},
      {"start_phase_rad", [](ScenarioFile& f, double v) { f.scenario.start_phase = v; }},
      {"cycles", [](ScenarioFile& f, double v) { f.scenario.cycles = v; }},
  };
  return table;
}

void read_sds(StrictTable& table, PlatformSection& platform) {
  const auto millimetres = [&](const char* key) {
    auto sd = read_sd(table, key);
    if (sd) *sd *= 1e-3;
    return sd;
  };
  platform.amplitude_sd = millimetres("amplitude_mm");
  platform.amplitude_y_sd = millimetres("amplitude_y_mm");
  platform.angular_frequency_sd = read_sd(table, "angular_frequency_rad_s");
  platform.phase_shift_sd = read_sd(table, "phase_shift_rad");
  platform.gravity_sd = read_sd(table, "gravity_m_s2");
  platform.tilt_x_sd = read_sd(table, "tilt_x_rad");
  platform.tilt_y_sd = read_sd(table, "tilt_y_rad");
}

/// A platform tilted by more is no platform.
constexpr double kSteepest = std::numbers::pi / 4;

double read_tilt(StrictTable& table, const char* key) {
  const double tilt = table.angle(key).value_or(0);
  if (std::abs(tilt) > kSteepest)
    table.fail(key, fmt::format("must lie within pi/4, not {}: degrees? write \"{}deg\"", tilt, tilt));
  return tilt;
}

/// Gravity as it is on earth, by a factor.
void refuse_other_units(const StrictTable& table, double gravity) {
  for (const auto& [factor, unit] :
       {std::pair{1e3, "mm/s^2"}, std::pair{1e2, "cm/s^2"}, std::pair{1e-3, "km/s^2"}})
    if (std::abs(gravity / factor - 9.81) < 0.2)
      table.fail("gravity_m_s2",
                 fmt::format("must be in m/s^2, about 9.81: {} is that in {}", gravity, unit));
}

}  // namespace

PlatformSection read_platform(StrictTable& table, WithSd with_sd) {
  PlatformSection platform;
  const auto millimetres = [&](const char* key) {
    auto value = table.not_negative(key);
    if (value) *value *= 1e-3;
    return value;
  };
  platform.amplitude = millimetres("amplitude_mm");
  platform.amplitude_y = millimetres("amplitude_y_mm");
  platform.angular_frequency = table.positive("angular_frequency_rad_s");
  platform.phase_shift = table.angle("phase_shift_rad");
  platform.gravity = table.positive("gravity_m_s2").value_or(9.81);
  refuse_other_units(table, platform.gravity);
  platform.tilt_x = read_tilt(table, "tilt_x_rad");
  platform.tilt_y = read_tilt(table, "tilt_y_rad");
  if (with_sd == WithSd::yes) read_sds(table, platform);
  table.finish();
  return platform;
}

void ScenarioFile::settle() {
  for (const auto& [name, tilt] :
       {std::pair{"tilt_x_rad", scenario.drive.tilt_x}, std::pair{"tilt_y_rad", scenario.drive.tilt_y}})
    if (std::abs(tilt) > kSteepest)
      throw InvalidInput(fmt::format("{} = {} is out of range: it must lie within pi/4", name, tilt));
  if (!mu1_over_mu2) return;
  if (!(*mu1_over_mu2 > 0))
    throw InvalidInput(fmt::format("mu1_over_mu2 must be greater than 0, not {}", *mu1_over_mu2));
  scenario.friction.reduced = scenario.friction.nominal / *mu1_over_mu2;
}

ScenarioFile read_scenario_file(const std::filesystem::path& path) {
  StrictTable top = StrictTable::read(path);
  require_kind(top, TomlKind::scenario, path.string());
  ScenarioFile file = read_scenario_tables(top);
  top.finish();
  return file;
}

ScenarioFile read_scenario_tables(StrictTable& top) {
  ScenarioFile file;
  if (auto table = top.table("platform")) {
    const PlatformSection platform = read_platform(*table, WithSd::no);
    auto& drive = file.scenario.drive;
    drive.amplitude = platform.amplitude.value_or(drive.amplitude);
    drive.amplitude_y = platform.amplitude_y.value_or(drive.amplitude);
    drive.angular_frequency = platform.angular_frequency.value_or(drive.angular_frequency);
    drive.phase_shift = platform.phase_shift.value_or(drive.phase_shift);
    drive.gravity = platform.gravity;
    drive.tilt_x = platform.tilt_x;
    drive.tilt_y = platform.tilt_y;
  }
  if (auto table = top.table("friction")) {
    auto& friction = file.scenario.friction;
    friction.nominal = table->not_negative("mu1").value_or(friction.nominal);
    const auto mu2 = table->not_negative("mu2");
    file.mu1_over_mu2 = table->positive("mu1_over_mu2");
    if (mu2 && file.mu1_over_mu2) table->fail("mu2", "and `mu1_over_mu2` mean the same; give one of them");
    friction.reduced = mu2.value_or(friction.reduced);
    friction.phase = table->angle("phi_rad").value_or(friction.phase);
    friction.pulse_width = table->angle("dtau_rad").value_or(friction.pulse_width);
    const auto lag = table->angle("lag_rad"), phase_lag = table->angle("phase_lag_rad");
    if (lag && phase_lag) table->fail("phase_lag_rad", "and `lag_rad` mean the same; give one of them");
    friction.lag = lag ? *lag : phase_lag.value_or(friction.lag);
    table->finish();
  }
  if (auto table = top.table("run")) {
    file.scenario.cycles = table->positive("cycles").value_or(file.scenario.cycles);
    if (const auto start = table->choice("start", kStarts))
      file.scenario.start = static_cast<model::Start>(*start);
    file.scenario.start_phase = table->angle("start_phase_rad").value_or(0);
    file.scenario.initial_velocity.x() = table->number("velocity_x_mm_s").value_or(0) * 1e-3;
    file.scenario.initial_velocity.y() = table->number("velocity_y_mm_s").value_or(0) * 1e-3;
    file.scenario.spin.rate = table->number("spin_rad_s").value_or(0);
    file.scenario.spin.radius = table->positive("radius_mm").value_or(0) * 1e-3;
    file.scenario.spin.inertia = table->positive("spin_inertia").value_or(file.scenario.spin.inertia);
    const auto samples = table->integer("samples_per_cycle").value_or(file.samples_per_cycle);
    if (samples < 1 || samples > 1'000'000) table->fail("samples_per_cycle", "must be between 1 and 1000000");
    file.samples_per_cycle = static_cast<int>(samples);
    table->finish();
  }
  if (auto table = top.table("sweep")) {
    file.over = table->texts("over").value_or(std::vector<std::string>{});
    table->finish();
  }
  file.settle();
  return file;
}

std::vector<std::string> scenario_parameter_names() {
  std::vector<std::string> names;
  for (const auto& [name, setter] : setters()) names.push_back(name);
  return names;
}

namespace {

std::string scenario_name_of(const std::string& campaign_name) {
  if (campaign_name == "angular_frequency_rad_s") return "omega_rad_s";
  if (campaign_name == "phase_shift_rad") return "epsilon_rad";
  if (campaign_name == "phase_lag_rad") return "lag_rad";
  return campaign_name;
}

}  // namespace

void set_scenario_parameter(ScenarioFile& file, const std::string& name, double value) {
  const auto found = setters().find(scenario_name_of(name));
  if (found == setters().end()) {
    const std::string near = nearest_word(name, scenario_parameter_names());
    throw UsageError(fmt::format("\"{}\" is not a parameter of a scenario{}; known: {}", name,
                                 near.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", near),
                                 fmt::join(scenario_parameter_names(), ", ")));
  }
  found->second(file, value);
}

model::Start parse_start(const std::string& word) {
  for (std::size_t i = 0; i < kStarts.size(); ++i)
    if (kStarts[i] == word) return static_cast<model::Start>(i);
  throw UsageError(fmt::format("the start must be one of {}, not \"{}\"", fmt::join(kStarts, ", "), word));
}

namespace {

Json without_spin(const model::Scenario& scenario) {
  const auto& d = scenario.drive;
  const auto& f = scenario.friction;
  return {{"amplitude_mm", d.amplitude * 1e3},
          {"amplitude_y_mm", d.amplitude_y * 1e3},
          {"omega_rad_s", d.angular_frequency},
          {"epsilon_rad", d.phase_shift},
          {"gravity_m_s2", d.gravity},
          {"tilt_x_rad", d.tilt_x},
          {"tilt_y_rad", d.tilt_y},
          {"mu1", f.nominal},
          {"mu2", f.reduced},
          {"phi_rad", f.phase},
          {"dtau_rad", f.pulse_width},
          {"lag_rad", f.lag},
          {"start", model::to_string(scenario.start)},
          {"start_phase_rad", scenario.start_phase},
          {"velocity_x_mm_s", scenario.initial_velocity.x() * 1e3},
          {"velocity_y_mm_s", scenario.initial_velocity.y() * 1e3},
          {"cycles", scenario.cycles}};
}

}  // namespace

Json json_of(const model::Scenario& scenario) {
  Json json = without_spin(scenario);
  if (scenario.spin.rate == 0) return json;
  json["spin_rad_s"] = scenario.spin.rate;
  json["radius_mm"] = scenario.spin.radius * 1e3;
  json["spin_inertia"] = scenario.spin.inertia;
  return json;
}

model::Scenario scenario_from(const Json& json) {
  const JsonPlace place{json, ""};
  constexpr double most_cycles = 1e6;  // as in a campaign
  ScenarioFile file;
  try {
    // In the order written: amplitude_mm sets both axes, amplitude_y_mm after it corrects the second.
    for (const auto& [name, value] : place.object().value.items())
      if (name != "start") set_scenario_parameter(file, name, place.at(name).number());
    file.scenario.start = parse_start(place.at("start").text());
    file.scenario.validate();
  } catch (const UsageError&) {
    place.refuse("a scenario");
  } catch (const model::InvalidParameter&) {
    place.refuse("a scenario that can be computed");
  }
  if (file.scenario.cycles > most_cycles) place.at("cycles").refuse("1000000 or less");
  return file.scenario;
}

}  // namespace tribotrack::apps
