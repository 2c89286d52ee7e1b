// The conditions of the paper's figures, as data/figure*.toml state them; the program carries these files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "apps/figures/figure.h"
#include "apps/files/scenario_file.h"
#include "apps/files/sweeps/sweep_axis.h"

namespace tribotrack::apps {

struct PaperScenario {
  std::string name;  ///< "figure6a", of data/figure6a.toml
  ScenarioFile file;
  Sweep sweep;  ///< its curves: the last axis runs along a curve, or tells trajectories apart
};

/// Throws std::logic_error where there is no data/NAME.toml or it sweeps nothing.
PaperScenario paper_scenario(std::string_view name);

/// "μ₁ = 0.1, μ₁/μ₂ = 8, g = 9.81 m/s², ...; 20 cycles from rest", plain text, without what is swept and what
/// is `told` elsewhere.
std::string conditions_text(const PaperScenario& scenario, const std::vector<std::string>& told = {});

/// "φ = π/4", "Aₑ = 0.28 mm": a swept parameter (scenario_parameter_names()) and its value in the unit of its
/// name.
std::string setting_text(const std::string& parameter, double value);

/// Along which this axis of the sweep runs.
FigureAxis axis_of(const SweepAxis& swept);

}  // namespace tribotrack::apps
