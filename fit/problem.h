// The problem of a fit: parameters and data.
//
//   Problem problem;
//   problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
//   SummaryRun run;
//   run.name = "phi 0, dtau pi/3";
//   run.scenario.drive.amplitude = run.scenario.drive.amplitude_y = 0.28e-3;   // m
//   run.scenario.drive.angular_frequency = 62.8;                               // rad/s
//   run.scenario.friction.phase = 0;                                           // phi
//   run.scenario.friction.pulse_width = 1.047;                                 // dtau
//   run.scenario.cycles = 20;
//   run.measured = displacement_from_alpha_v({5.93, 0.02}, {1.78e-3, 0.04e-3}, 62.8, 20);
//   problem.summary_runs = {run};                                              // two numbers a run
//   const FitResult result = estimate(problem);                                // fit/estimate.h
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fit/measurement.h"
#include "fit/track_table.h"
#include "model/scenario.h"

namespace tribotrack::fit {

/// A parameter that can be fitted. Values are SI; scale is the factor on every measured length (1 = as
/// measured). Those behind tilt_y are conditions only (Problem::conditions).
enum class FitParameter {
  mu1,
  mu2,
  lag,
  delay,
  amplitude,
  angular_frequency,
  scale,
  tilt_x,
  tilt_y,
  amplitude_ratio,  ///< factor on the A_y/A of every run, their geometric mean kept; 1 = as given
  phase_shift,      ///< rad, added to the epsilon of every run
  phase_reference,  ///< rad, added to the phase of every pulse: where the platform's phase is counted from
  gravity,
  slope,        ///< rad, added to the slope of every incline; 0 = as given
  start_phase,  ///< rad, added to the phase at which runs start that start at rest
  // Departures from the paper's law of friction, 0 for the law itself (model/rival_laws.h):
  mu2_width,       ///< 1/rad, relative rise of mu2 with the width of the gate, about the mean of all runs
  wear,            ///< relative rise of mu1 and mu2 from the first run of the campaign to the last
  stribeck,        ///< relative
  stribeck_speed,  ///< RivalLaw::fading, relative to A w or, where nothing is driven, to the fastest slide
  viscous,         ///< 1/s
  gate_edges,      ///< rad^2, square of what each change of mu takes: displacements are linear in it
  mu2_speed,       ///< relative rise of mu2 at the platform's speed
  static_friction  ///< relative
};

/// Those that need an integration under another law of friction.
inline constexpr std::array kLaws = {FitParameter::stribeck,  FitParameter::stribeck_speed,
                                     FitParameter::viscous,   FitParameter::gate_edges,
                                     FitParameter::mu2_speed, FitParameter::static_friction};

const char* to_string(FitParameter parameter);  ///< "mu1", "mu2", "phase_lag_rad", "delay_s", "amplitude_mm",
                                                ///< ... as in campaigns

struct Prior {
  double mean = 0;
  double sd = 0;
};

/// A condition that all runs share, known with an sd: an unknown of the fit whose prior mean is the runs'
/// value. Amplitude and frequency are those of the first driven run, to which the others keep
/// their ratio; tilts and gravity likewise.
struct Condition {
  FitParameter quantity = FitParameter::amplitude;
  double sd = 0;     ///< SI, in the unit of the quantity (relative for scale and amplitude_ratio)
  std::string from;  ///< source of value and sd, for the budget: "marker, 14 runs", "campaign"
};

/// Condition::from of a condition that an explanation sets free.
inline constexpr const char* kSetFree = "set free";
/// Condition::from of the possible effect of compression on the platform's motion.
inline constexpr const char* kFromCoder = "coder";

/// Errors of the conditions that one run measures for itself (its gate, the phase at its start, its own A).
struct OwnErrors {
  std::vector<model::Parameter> parameters;
  Eigen::MatrixXd covariance;  ///< SI, of them
  /// Share of what they move a displacement by to which that is linear in them; beyond, it moves anywhere.
  double bent = 0;
  /// Adds to the variance of a parameter, and to the covariance of two.
  void add(model::Parameter parameter, double variance);
  void add(model::Parameter one, model::Parameter other, double both);
  double sd(model::Parameter parameter) const;  ///< 0 where it has none
  OwnErrors without(model::Parameter parameter) const;
};

/// A run with a displacement over whole cycles, measured by us or elsewhere.
struct SummaryRun {
  std::string name;
  model::Scenario scenario;  ///< all but the fitted parameters: drive, phi, dtau, start, start_phase, cycles
  Displacement measured;
  bool amplitude_from_track = false;  ///< A was measured in the same picture and scales with `scale`
  OwnErrors own = {};                 ///< counted beside the covariance of `measured`
  double course = 0;      ///< position in the campaign, -1/2 for its first run to 1/2 for its last
  bool held_out = false;  ///< predicted by the fit, not fitted
};

/// Spin of the part of a free slide at its first point, and radius of its bearing face: nuisance parameters
/// with this prior. A disc that does not bear on its edge spins longer, and its spin lowers its friction
/// less.
struct DiscSpin {
  double rate = 0;     ///< rad/s
  double bearing = 0;  ///< ln of the bearing face's radius over the part's; 0: the whole face bears
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (rate, bearing)
  double rate_sd() const { return std::sqrt(covariance(0, 0)); }
  /// Between nearly a point and all of a disc, or the corners of a square: beyond them nothing bears, and a
  /// part of next to no inertia, which angles of no slide lead to, is followed in ever shorter steps.
  static constexpr double kLeastBearing = -3, kMostBearing = 0.35;
  static double within(double bearing, bool round) {
    return std::clamp(bearing, kLeastBearing, round ? 0 : kMostBearing);
  }
};

/// A run fitted point by point: the model's trajectory and nuisance parameters (start point; the platform's
/// phase; initial velocity of a free slide). A track in the camera's frame is compared with the
/// motion in the platform's frame plus the platform's own.
struct TrajectoryRun {
  std::string name;
  model::Scenario scenario;  ///< time 0 of the scenario is track.time.front()
  TrackTable track;
  /// Platform at rest, initial velocity unknown, mu1 alone. estimate() uses its longest stretch without a
  /// blow and takes the spin from the track's angle where that is seen.
  bool free_slide = false;
  bool amplitude_from_track = false;
  /// sd of the platform's phase at the start, rad: where above 0, a nuisance with scenario.start_phase as its
  /// prior mean. It moves drive and pulses alike.
  double start_phase_sd = 0;
  std::optional<DiscSpin> spin = std::nullopt;  ///< of a free slide; needs track.radius
  /// Of a free slide on a plane tilted by the angle theta: u' = g sin(theta) e - mu g cos(theta) u/|u|, e
  /// pointing downhill. rad; > 0: the part slides down, < 0: it was pushed up; 0: a level platform.
  double slope = 0;
  /// e in the track's frame. Zero: estimate() takes the direction of the motion.
  Eigen::Vector2d downhill = Eigen::Vector2d::Zero();
  /// Of its gate, and of what else this run alone is known by; the phase at the start has start_phase_sd.
  OwnErrors own = {};
  double course = 0;  ///< as SummaryRun::course
};

struct Problem {
  std::vector<FitParameter> free;        ///< what is fitted
  std::map<FitParameter, double> fixed;  ///< values of mu1, mu2, lag, delay not fitted (lag, delay: 0)
  std::map<FitParameter, double> start;  ///< first guesses; missing ones are chosen
  std::map<FitParameter, Prior> prior;
  /// sd of mu1 between free slides: each has its own, mu1 is their mean. 0: estimate() finds it from the
  /// slides.
  double between_slides = 0;
  /// The same where slides have a viscous part, and the sd of that, 1/s: each slide has its own, `viscous` is
  /// their mean. 0: estimate() finds them from slides that reject a constant friction.
  struct BetweenViscousSlides {
    double mu1 = 0, viscous = 0;
  } between_viscous_slides = {};
  /// What is not fitted but known to an sd only; independent errors of one quantity may stand apart. One that
  /// is fitted is left out.
  std::vector<Condition> conditions;
  /// Conditions that also rest on a value taken as exact, by its name: {scale, "diameter_mm"}. For the
  /// budget.
  std::vector<std::pair<FitParameter, std::string>> exact;
  std::vector<SummaryRun> summary_runs;
  std::vector<TrajectoryRun> trajectory_runs;
  bool fits(FitParameter parameter) const { return std::ranges::count(free, parameter) > 0; }
  bool has_pulses() const;          ///< in a driven run
  bool has_driven_tracks() const;   ///< trajectory runs that are no free slides
  bool counts_run_scatter() const;  ///< friction differs from run to run: an error of each run's own
  /// An explanation sets it free.
  bool sets_free(FitParameter quantity) const;
  /// Throws DataError: nothing to fit, a value missing that is neither free nor fixed, data that are not
  /// numbers. Fewer data than unknowns are no error: the result then states what can be determined.
  void validate() const;
  /// Where no driven run moved beyond its error (chi^2 of the displacement with 99.9 %): the bound on mu that
  /// follows and the remedy, as a sentence. nullopt where something moved, or where nothing was driven.
  std::optional<std::string> stuck_throughout() const;
  double typical_displacement() const;  ///< m, median over the runs
};

}  // namespace tribotrack::fit
