// The laws of extremes.h, and the collector of its cases.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/bench/extremes/extremes.h"

namespace tribotrack::bench {

/// (A, w) -> (A/9, 3w) leaves x/A as a function of wt: a = A w^2, and with it every ratio to mu g, stays.
ExtremeLaw scaling_law();
/// The end point of a neighbouring scenario agrees, relative to the path or A, whichever is longer.
ExtremeLaw same_as(const std::string& text, const model::Scenario& other, double allowed);
ExtremeLaw ends_at(const std::string& text, const Eigen::Vector2d& place, double allowed = 1e-11);
ExtremeLaw never_moves();
/// From rest the speed grows at most at |drive| - mu g: path <= surplus T^2/2. The violation is what exceeds
/// it, relative to A.
ExtremeLaw creeps_at_most(double surplus);
/// Two starts never separate: |x - x'| <= |u0 - u0'| T. The violation is what exceeds it, relative to A.
ExtremeLaw never_separates_from(const model::Scenario& other);
/// Once periodic, every cycle adds the drift of the periodic orbit.
ExtremeLaw last_half_adds_drifts();
/// Drive along a line through the origin: the part stays on it.
ExtremeLaw stays_on_line(double slope);

/// a = A w^2, m/s^2.
double drive_strength(const model::Scenario& scenario);
/// For names: %g.
std::string number(double value);
/// End point at the default tolerance.
Eigen::Vector2d end_of(const model::Scenario& scenario);

/// What the cases start from, and where they go.
struct ExtremeList {
  struct Regime {
    std::string name;
    model::Scenario base;
  };
  bool quick = false;
  Regime slip, stick;
  std::vector<ExtremeCase> cases;

  explicit ExtremeList(bool quick);
  void add(std::string name, const model::Scenario& scenario, ExtremeLaw law) {
    cases.push_back({std::move(name), scenario, std::move(law)});
  }
  /// For both regimes: `make(base)` changes a copy of the base, `law(base, scenario)` says what must hold.
  template <class Make, class Law>
  void add_both(const std::string& name, Make make, Law law) {
    for (const Regime* regime : {&slip, &stick}) {
      model::Scenario scenario = regime->base;
      make(scenario);
      add(name + ", " + regime->name, scenario, law(regime->base, scenario));
    }
  }
};

void add_friction_extremes(ExtremeList& list);
void add_threshold_extremes(ExtremeList& list);
void add_pulse_extremes(ExtremeList& list);
void add_drive_extremes(ExtremeList& list);
void add_start_extremes(ExtremeList& list);

}  // namespace tribotrack::bench
