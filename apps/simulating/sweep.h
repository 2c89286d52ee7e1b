// What a scenario is swept over: "NAME=FROM:TO:COUNT" or "NAME=VALUE,VALUE,...", on the command line and in
// [sweep] of a scenario file.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "apps/files/scenario_file.h"
#include "apps/program/context.h"
#include "model/scenario.h"

namespace tribotrack::apps {

/// The most scenarios of one sweep.
inline constexpr double kMostScenarios = 1e8;

/// One parameter of a scenario and its values, in the unit of its name.
class SweepAxis {
 public:
  /// Throws UsageError where the text does not read.
  explicit SweepAxis(const std::string& text);
  /// Throws UsageError without values, and for an angle that is none.
  SweepAxis(std::string name, std::vector<double> values);
  const std::string& name() const { return name_; }
  /// As given; of listed values the name.
  const std::string& text() const { return text_; }
  std::size_t count() const { return values_.size(); }
  double value(std::size_t k) const { return values_[k]; }

 private:
  std::string name_, text_;
  std::vector<double> values_;
};

/// One or two axes. Throws UsageError for any other number, for two that mean the same, and for more than
/// kMostScenarios.
std::vector<SweepAxis> sweep_axes(const std::vector<std::string>& texts);

/// A scenario and its axes as a row of scenarios, the last axis running fastest.
class Sweep {
 public:
  Sweep(ScenarioFile base, std::vector<SweepAxis> axes);
  const std::vector<SweepAxis>& axes() const { return axes_; }
  std::size_t count() const { return count_; }
  double value(std::size_t index, std::size_t axis) const;  ///< of scenario `index`
  model::Scenario scenario(std::size_t index) const;

 private:
  ScenarioFile base_;
  std::vector<SweepAxis> axes_;
  std::size_t count_ = 1;
};

// The model solved for every scenario of a sweep.

/// One value for each scenario (Sweep::scenario()); NaN where there is none.
struct SweptModel {
  std::vector<double> alpha_rad, v_mm_s;                ///< of the runs
  std::vector<double> steady_alpha_rad, steady_v_mm_s;  ///< of the steady motion under the same conditions
};

/// On all threads, with progress. Refuses a scenario out of range before the work, not after it: InvalidInput
/// naming the axes.
SweptModel solve(const Sweep& sweep, const Context& context);

}  // namespace tribotrack::apps
