// What a run of the friction model needs, decided from its scenario before anything is integrated: the answer
// to `tribotrack simulate --explain`.
//   for (const PlanStage& stage : plan(scenario))
//     if (!stage.on) print(stage.name + " left out: " + stage.reason);
#pragma once

#include <string>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::model {

/// One piece of machinery: needed or left out, and why.
struct PlanStage {
  std::string name;
  bool on = false;
  std::string reason;      ///< with its figure
  double error_bound = 0;  ///< m, what leaving it out can add to the end point
};

/// Stick and release (can the drive fall below friction?), friction switches (is mu ever switched?),
/// transient (does the start follow a periodic motion?), every cycle (do they repeat, so that the rest
/// follows by addition?). Costs one steady_orbit() where cycles could repeat. `tribotrack bench model`
/// measures what each saves. Throws InvalidParameter for a bad scenario.
std::vector<PlanStage> plan(const Scenario& scenario);

/// Least |d(wt)| over a cycle, m/s^2: where friction is below it nothing ever sticks. |d|^2 is a
/// trigonometric polynomial of degree 2; its minima are found by safeguarded Newton steps between samples of
/// its slope.
double least_drive(const Drive& drive);

/// Cycles that are integrated until one repeats the last, for a contraction per cycle. A part that sticks
/// (contraction 0) repeats at once.
double cycles_until_repeating(double contraction);

}  // namespace tribotrack::model
