// What does a fit say where the laboratory is not the model? Campaigns from a platform that may be tilted,
// elliptic or out of phase, under friction that may depend on speed, width, time and the run, given to the
// fit as someone would who knows nothing of that.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "apps/bench/coverage.h"
#include "fit/problem.h"

namespace tribotrack::bench {

struct Laboratory {
  double mu1 = 0.1, mu2 = 0.02, lag = 0.2;
  // What the campaign does not say.
  double tilt_x = 0, tilt_y = 0;        ///< rad
  double ratio = 1, epsilon_error = 0;  ///< A_y/A about their mean; rad
  double edges = 0;                     ///< rad, of each change of mu, about the edge
  double stribeck = 0, fading = 0.25;   ///< relative, and by which share of A w it fades
  double viscous = 0;                   ///< 1/s
  double heating = 0;                   ///< relative rise of mu2 for 1 rad of gate, about pi/3
  double wear = 0;                      ///< relative rise of mu1 and mu2 from the first run to the last
  double scatter = 0;                   ///< relative, of both from run to run
  int bad_run = -1;                     ///< whose phi was 0.7 rad more than it says
  double true_over_stated = 1;          ///< sd of the errors
};

/// sds of alpha, rad, and of v, relative.
struct AlphaVErrors {
  double alpha = 0.002, v = 0.002;
};

/// Displacement of one run, m, by Moreau's time stepping (J. J. Moreau, Unilateral contact and dry friction
/// in finite freedom dynamics, 1988) with the midpoint's friction where it slides: shares nothing with the
/// integrator that fits.
Eigen::Vector2d stepped(const Laboratory& lab, const model::Scenario& scenario, double mu1, double mu2);

/// Eight phi at one width, six widths at one phi, as the campaign believes them. Nothing is said of
/// conditions: all that is not fitted is taken as exact.
fit::Problem campaign_of(const Laboratory& lab, const AlphaVErrors& errors, Dice& dice);

/// Adds the conditions that `tribotrack fit` adds to a table of which nobody says how well things are known.
void take_nothing_as_exact(fit::Problem& problem);

/// What is drawn. "nothing": the model. "the usual", all together: a level to 1 mrad, A_y/A to 1 %, epsilon
/// to 1 deg (sds), edges of 0 to 0.2 rad, Stribeck 0 to 15 % (fading by 0.1 to 0.5 A w), mu2 0 to 10 % higher
/// for 60 deg more of gate, mu scattering by 0 to 3 %, errors 0.7 to 1.5 times as large as stated. Else one
/// departure of one to six times the sd by which a fit expects it: a tilt of 5 to 10 mrad, A_y/A 3 to 6 %
/// off, epsilon 0.05 to 0.1 rad, Stribeck 25 to 50 %, mu2 10 to 30 % a radian, wear 6 to 13 %, a phi that is
/// 0.7 rad off, mu scattering by 2.4 to 4.8 %.
inline constexpr std::array kFaults{"nothing",  "the usual", "tilt", "amplitude_ratio", "phase_shift",
                                    "stribeck", "mu2_width", "wear", "bad_run",         "run_scatter"};

/// Counts of one fault over one noise level.
struct LaboratoryRow {
  std::string fault;
  AlphaVErrors errors;
  int campaigns = 0;
  int use = 0, care = 0;        ///< verdicts; the rest is not to be used
  int intervals = 0, held = 0;  ///< of mu1, mu2 and lag in those, and how many hold the truth
  /// Verdict "use" over a value that is farther outside its interval than a quarter of its length.
  int wrong = 0;
  int rejected = 0;  ///< p < 1e-3
  int named = 0;     ///< of them, whose fault is what the values are quoted under, or the first explanation
};

/// At three noise levels, the middle one alone when quick.
std::vector<LaboratoryRow> laboratory(const BenchOptions& options);

}  // namespace tribotrack::bench
