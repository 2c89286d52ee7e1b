// The stiff and extreme scenarios of the friction model, each with a law that must hold there: one list for
// the benchmark's table and for the tests.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::bench {

/// A statement about the end point of one scenario, and how far it is from holding.
struct ExtremeLaw {
  std::string text;
  double allowed = 0;  ///< of the violation, relative to the path unless the text says otherwise
  std::function<double(const model::Scenario&, const Eigen::Vector2d& end)> violation;
};

struct ExtremeCase {
  std::string name;
  model::Scenario scenario;
  ExtremeLaw law;
};

/// All of them, the ordinary case first. `quick`: 2 cycles each instead of 20 (100 instead of 1e6), the same
/// cases. Where a case exists for a part that always slips (mu1 = 0.1, dtau = pi/2) and for one that sticks
/// in every cycle (mu1 = 0.122, dtau = pi/6), both are there.
std::vector<ExtremeCase> extreme_cases(bool quick);

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

}  // namespace tribotrack::bench
