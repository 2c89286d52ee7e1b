#include "model/plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "model/steady_orbit.h"

namespace tribotrack::model {

namespace {

/// Two velocities this close, relative to the speed, count as the same: cycles repeat from there on.
constexpr double kSameVelocity = 4e-16;

template <class... Figures>
std::string with_figures(const char* format, Figures... figures) {
  char text[240];
  std::snprintf(text, sizeof text, format, static_cast<double>(figures)...);
  return text;
}

/// The scene in the terms the decisions are made in.
struct Scene {
  explicit Scene(const Scenario& s)
      : scenario(s),
        least(least_drive(s.drive)),
        pulses(s.friction.pulse_width > 0 && s.friction.nominal != s.friction.reduced),
        friction(std::max(s.friction.nominal, pulses ? s.friction.reduced : 0.0) * s.drive.gravity),
        may_stick(least <= friction),
        cycles(s.end_time() * s.drive.angular_frequency / (2 * std::numbers::pi)) {}

  const Scenario& scenario;
  double least;
  bool pulses;
  double friction;
  bool may_stick;
  double cycles;
};

PlanStage stick(const Scene& scene) {
  if (scene.may_stick)
    return {"stick and release", true,
            with_figures("friction %.4g m/s^2 can hold the part: the drive falls to %.4g m/s^2",
                         scene.friction, scene.least)};
  return {
      "stick and release", false,
      with_figures("the drive never falls below %.4g m/s^2, friction is at most %.4g m/s^2: the part, once "
                   "sliding, never sticks",
                   scene.least, scene.friction)};
}

PlanStage switches(const Scene& scene) {
  const Friction& f = scene.scenario.friction;
  if (scene.pulses)
    return {"friction switches", true,
            with_figures("mu switches between %.4g and %.4g twice a cycle", f.nominal, f.reduced)};
  return {"friction switches", false, "mu is constant: a pulse of no width, or mu2 = mu1"};
}

PlanStage transient(const Scene& scene, const std::optional<SteadyOrbit>& orbit) {
  if (scene.scenario.start == Start::rest)
    return {"transient", true, "the run starts from rest: its first cycles differ from the others"};
  if (scene.scenario.start == Start::circling)
    return {"transient", scene.pulses,
            scene.pulses
                ? "the run starts circling at constant mu1: with the pulses its first cycles differ from "
                  "the others"
                : "the run starts on the circle of constant mu1 and stays there"};
  if (!orbit) return {"transient", true, "no unique periodic motion exists to start from"};
  const double settle = cycles_until_repeating(orbit->contraction);
  return {"transient", false,
          with_figures(
              "the run starts on a periodic motion, found directly by Newton's method in %.0f iterations; "
              "a run would settle in %.0f cycles",
              orbit->newton_iterations, settle)};
}

/// No two motions separate, and near the orbit they approach by its contraction c per cycle: once two
/// cycles begin within e of each other all later ones begin within e/(1 - c), and each adds its own drift to
/// within that times the period.
PlanStage every_cycle(const Scene& scene, const std::optional<SteadyOrbit>& orbit) {
  const char* name = "every cycle";
  if (!orbit) return {name, true, "no unique periodic motion: cycles need not repeat"};
  const double c = orbit->contraction;
  const bool on_orbit = scene.scenario.start == Start::steady;
  const double integrated = on_orbit ? 2 : cycles_until_repeating(c);
  if (scene.cycles <= integrated)
    return {
        name, true,
        with_figures("%.4g cycles are fewer than the %.4g after which they repeat (contraction %.3g a cycle)",
                     scene.cycles, integrated, c)};
  const Drive& d = scene.scenario.drive;
  const double w = d.angular_frequency, unit = std::max(d.amplitude, d.amplitude_y) * w;
  const double copies = scene.cycles - integrated, period = 2 * std::numbers::pi / w;
  const double apart = c > 0 ? kSameVelocity * (orbit->velocity.norm() + 2 * unit) / (1 - c) : 0;
  return {name, false,
          with_figures("cycles repeat after %.0f (contraction %.3g a cycle): the other %.6g are added",
                       integrated, c, copies),
          copies * period * apart};
}

}  // namespace

double least_drive(const Drive& drive) {
  // d = constant + p cos + q sin; half the slope of |d|^2 has at most four roots a cycle.
  constexpr double kTurn = 2 * std::numbers::pi;
  const Eigen::Vector2d d0 = drive.acceleration(0), constant = (d0 + drive.acceleration(kTurn / 2)) / 2,
                        p = d0 - constant, q = drive.acceleration(kTurn / 4) - constant;
  const auto d = [&](double s) -> Eigen::Vector2d { return constant + p * std::cos(s) + q * std::sin(s); };
  const auto slope = [&](double s) { return d(s).dot(q * std::cos(s) - p * std::sin(s)); };
  constexpr int kSamples = 64;
  double least = d0.norm();
  for (int k = 0; k < kSamples; ++k) {
    double low = kTurn * k / kSamples, high = kTurn * (k + 1) / kSamples;
    least = std::min(least, d(low).norm());
    if (slope(low) > 0 || slope(high) < 0) continue;
    for (int i = 0; i < 60; ++i) {
      const double middle = (low + high) / 2;
      (slope(middle) < 0 ? low : high) = middle;
    }
    least = std::min(least, d(high).norm());
  }
  return least;
}

double cycles_until_repeating(double contraction) {
  if (!(contraction > 0)) return 2;
  if (!(contraction < 1)) return HUGE_VAL;
  return 3 + std::ceil(std::log(kSameVelocity) / std::log(contraction));
}

std::vector<PlanStage> plan(const Scenario& scenario) {
  scenario.validate();
  const Scene scene(scenario);
  const bool worth_knowing = scenario.start != Start::rest || scene.cycles > 2;
  const auto orbit = worth_knowing ? steady_orbit(scenario) : std::nullopt;
  return {stick(scene), switches(scene), transient(scene, orbit),
          worth_knowing
              ? every_cycle(scene, orbit)
              : PlanStage{"every cycle", true, with_figures("%.4g cycles: nothing to repeat", scene.cycles)}};
}

}  // namespace tribotrack::model
