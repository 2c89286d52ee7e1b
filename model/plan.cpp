#include "model/plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace tribotrack::model {

namespace {

std::string with_figures(const char* format, double a, double b = 0) {
  char text[200];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

/// Least |d(wt)| over a cycle. Exact for a circular drive; sampled finely for the others, where |d|^2 is a
/// trigonometric polynomial of degree 2 and 720 samples leave less than 1e-4 of its range between them.
double least_drive(const Drive& drive) {
  double least = drive.acceleration(0).norm();
  for (int k = 1; k < 720; ++k)
    least = std::min(least, drive.acceleration(k * std::numbers::pi / 360).norm());
  return least;
}

}  // namespace

std::vector<PlanStage> plan(const Scenario& scenario) {
  const Drive& drive = scenario.drive;
  const Friction& friction = scenario.friction;
  const bool driven = drive.amplitude > 0 || drive.amplitude_y > 0;
  const bool pulses = friction.pulse_width > 0 && friction.nominal != friction.reduced;
  const bool tilted = drive.tilt_x != 0 || drive.tilt_y != 0;
  const double strongest = std::max(friction.nominal, pulses ? friction.reduced : 0.0) * drive.gravity;
  const double least = least_drive(drive);
  const bool may_stick = least <= strongest;

  std::vector<PlanStage> stages;
  stages.push_back(
      {"stick and release", may_stick,
       may_stick
           ? with_figures("friction %.4g m/s^2 can hold the part: the drive falls to %.4g m/s^2", strongest,
                          least)
           : with_figures("the drive never falls below %.4g m/s^2, friction is at most %.4g m/s^2: the part, "
                          "once sliding, never sticks",
                          least, strongest),
       may_stick ? 0 : 0.05, 0});
  stages.push_back({"friction switches", pulses,
                    pulses ? with_figures("mu switches between %.4g and %.4g twice a cycle", friction.nominal,
                                          friction.reduced)
                           : "mu is constant: a pulse of no width, or mu2 = mu1",
                    pulses ? 0 : 0.4, 0});
  stages.push_back({"platform drive", driven,
                    driven ? with_figures("a = A w^2 = %.4g m/s^2",
                                          drive.amplitude * drive.angular_frequency * drive.angular_frequency)
                           : "A = 0: a free slide",
                    driven ? 0 : 0.9, 0});
  stages.push_back(
      {"tilt", tilted, tilted ? "the platform is tilted" : "no tilt was given", tilted ? 0 : 0.01, 0});
  const bool transient = scenario.start == Start::rest;
  stages.push_back({"transient from rest", transient,
                    transient ? "the run starts from rest: the first cycles differ from the rest"
                              : "the run starts on a periodic motion, found directly by Newton's method",
                    0, 0});
  return stages;
}

}  // namespace tribotrack::model
