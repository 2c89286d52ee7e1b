// The typing error behind a fit that fails or is absurd.
//
//   const Typed typed{.amplitude = true, .directions = true};
//   for (const SlipFound& slip : find_slips(problem, result, typed))
//     std::printf("%s times %g: p = %g\n", to_string(slip.what), slip.factor, slip.p_value);
//
// A unit, a peak-to-peak value, a sense of rotation: the typed value is then wrong by one of a few factors
// or angles, none of which is near 1. Each is undone in the problem and the fit repeated. One that describes
// the data (p > 0.01) with friction as it is found (mu1 from 0.005 to 0.6, mu2 below it) where the fit as
// given does not, is the slip. Lengths, amplitude and friction scale together: a wrong scale under which A
// was measured as well changes mu1 and mu2 by its factor, and the quality of the fit not at all.
#pragma once

#include <map>
#include <vector>

#include "fit/fit_result.h"
#include "fit/problem.h"

namespace tribotrack::fit {

/// What the campaign states and no recording shows.
struct Typed {
  bool amplitude = false, frequency = false;
  bool timing = false;      ///< phi and dtau, commanded
  bool directions = false;  ///< alpha and v, from a table
  bool lengths = false;     ///< recordings are scaled by one length, or one number, that is given
};

struct SlipFound {
  enum class What {
    amplitude,
    frequency,
    lengths,  ///< what scales them
    phi,      ///< of all runs, as the next ones
    dtau,
    timing,  ///< phi and dtau
    alpha,
    angles,          ///< all three
    alpha_mirrored,  ///< y downwards, or the platform's sense: the same
    phi_turned,      ///< by quarter turns; where the lag is fitted it is the lag
    phi_edge,        ///< counted to another edge of the pulse: phi + factor dtau opens it
    phi_reversed     ///< counted against the platform's sense: -phi + factor dtau opens it
  };
  What what = What::amplitude;
  /// What the typed value is multiplied by; of phi_turned the angle in rad that is added, of phi_edge and
  /// phi_reversed the share of dtau.
  double factor = 1;
  std::map<FitParameter, double> values;
  double chi2 = 0;
  int dof = 0;
  double p_value = 0;
};

/// A fit that did not converge or that chi^2 rejects (p < 0.001); one with friction that no pair of bodies
/// has.
bool is_failing(const FitResult& result);
bool is_absurd(const FitResult& result);

/// Those that explain a failing or absurd fit equally well by chi^2, the likeliest first; empty if none
/// does. Of
/// a sound one it is half the amplitude alone, where that describes the data better: twice the amplitude
/// leaves room for a friction under which they are nearly the same. Free slides are looked at for their scale
/// only. Some 20 ms each for 14 runs.
std::vector<SlipFound> find_slips(const Problem& problem, const FitResult& result, const Typed& typed);

}  // namespace tribotrack::fit
