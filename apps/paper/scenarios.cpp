#include "apps/paper/scenarios.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "apps/figures/axes.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/page/text.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {
namespace {

/// A parameter of a scenario as the paper writes it.
struct Symbol {
  const char* parameter;
  const char* symbol;
  const char* unit;  ///< "": a pure number
  const char* quantity;
};

constexpr Symbol symbols[] = {
    {"mu1", "μ₁", "", "friction coefficient μ₁"},
    {"mu1_over_mu2", "μ₁/μ₂", "", "ratio μ₁/μ₂"},
    {"gravity_m_s2", "g", "m/s²", "gravity g"},
    {"amplitude_mm", "Aₑ", "mm", "amplitude Aₑ"},
    {"omega_rad_s", "ω", "rad/s", "angular frequency ω"},
    {"epsilon_rad", "ε", "rad", "phase shift ε of the axes"},
    {"phi_rad", "φ", "rad", "phase shift φ"},
    {"dtau_rad", "Δτ", "rad", "pulse width Δτ"},
};

const Symbol& symbol_of(const std::string& parameter) {
  const auto* found = std::ranges::find(symbols, parameter, &Symbol::parameter);
  if (found == std::end(symbols)) throw std::logic_error("no figure of the paper is swept over " + parameter);
  return *found;
}

bool is_angle(const Symbol& symbol) {
  return std::string_view(symbol.unit) == "rad";
}

/// "11π/9" for multiples of π/36 and of π/10, else as elsewhere on pages.
std::string angle_text(double rad) {
  for (const long n : {36, 10}) {
    const double whole = std::round(rad * static_cast<double>(n) / std::numbers::pi);
    if (std::abs(rad - whole * std::numbers::pi / static_cast<double>(n)) < 1e-9)
      return multiple_of_pi(std::lround(whole), n);
  }
  return angle(rad);
}

}  // namespace

PaperScenario paper_scenario(std::string_view name) {
  const auto scenarios = paper_scenarios();
  const auto found = std::ranges::find(scenarios, name, &EmbeddedScenario::name);
  if (found == scenarios.end()) throw std::logic_error(fmt::format("there is no data/{}.toml", name));
  StrictTable table = StrictTable::parse(found->toml, fmt::format("data/{}.toml", name));
  const ScenarioFile file = read_scenario_tables(table);
  table.finish();
  if (file.over.empty()) throw std::logic_error(fmt::format("data/{}.toml sweeps nothing", name));
  return {std::string(name), file, Sweep(file, sweep_axes(file.over))};
}

std::string setting_text(const std::string& parameter, double value) {
  const Symbol& symbol = symbol_of(parameter);
  if (is_angle(symbol)) return fmt::format("{} = {}", symbol.symbol, angle_text(value));
  return fmt::format("{} = {}{}{}", symbol.symbol, number(value), *symbol.unit ? " " : "", symbol.unit);
}

std::string conditions_text(const PaperScenario& scenario, const std::vector<std::string>& told) {
  const model::Scenario& s = scenario.file.scenario;
  const std::pair<const char*, double> settings[] = {
      {"mu1", s.friction.nominal},
      {"mu1_over_mu2", s.friction.nominal / s.friction.reduced},
      {"gravity_m_s2", s.drive.gravity},
      {"amplitude_mm", 1e3 * s.drive.amplitude},
      {"omega_rad_s", s.drive.angular_frequency},
      {"epsilon_rad", s.drive.phase_shift},
      {"phi_rad", s.friction.phase},
      {"dtau_rad", s.friction.pulse_width}};
  std::vector<std::string> fixed;
  const std::vector<SweepAxis>& axes = scenario.sweep.axes();
  for (const auto& [parameter, value] : settings)
    if (std::ranges::find(axes, parameter, &SweepAxis::name) == axes.end() &&
        std::ranges::find(told, parameter) == told.end())
      fixed.push_back(setting_text(parameter, value));
  return fmt::format("{}; {} cycles from {}", fmt::join(fixed, ", "), number(s.cycles),
                     model::to_string(s.start));
}

FigureAxis axis_of(const SweepAxis& swept) {
  const Symbol& symbol = symbol_of(swept.name());
  const std::string title =
      *symbol.unit ? fmt::format("{}, {}", symbol.quantity, symbol.unit) : symbol.quantity;
  const double from = swept.value(0), to = swept.value(swept.count() - 1);
  const Range ends = padded({std::min(from, to), std::max(from, to)}, 0.03);
  if (is_angle(symbol)) return angle_axis(title, ends.low, ends.high);
  return {.title = title, .low = ends.low, .high = ends.high};
}

}  // namespace tribotrack::apps
