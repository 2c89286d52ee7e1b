// What would explain the residuals: score tests over everything that the fit takes as exact.
//
// With r the whitened residuals at the minimum, J their derivatives by the unknowns and G those by something
// that the fit holds at a value (a tilt, a law's strength, one run's two numbers), chi^2 with it free is
// lower by
//   b' S^-1 b,  b = G_' r,  S = G_' G_,  G_ = (1 - J (J'J)^-1 J') G,
// to first order, at s = -S^-1 b: Rao's score test (C. R. Rao, Math. Proc. Cambridge Phil. Soc. 44, 1948,
// 50-57). It takes no refit. What is known to an sd is an unknown of the fit already: there G is the row of
// its prior, and the test asks what chi^2 would be without it. Those that the fall of chi^2 speaks for are
// refitted, since a large effect is not linear.
#pragma once

#include <string>
#include <vector>

#include "fit/fit_result.h"
#include "fit/minimum/minimise.h"
#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

/// The name of a spin of free slides that was not seen: found by a refit, not by a score test.
inline constexpr const char* kUnseenSpin = "unseen_spin";

/// An explanation and the problem in which it holds.
struct ExplainedProblem {
  Explanation found;
  Problem problem;
  Eigen::VectorXd values;  ///< where its refit ended, of the unknowns of the fit it explains; else empty
  double gain = 0;         ///< fall of Akaike's criterion; of slides, with errors of an unknown size
};

/// Best first. `rejected`: those that are near the best are refitted. `best` is the minimum of residuals
/// without excess variance.
std::vector<ExplainedProblem> explanations(const Residuals& residuals, const Minimum& best, bool rejected,
                                           int threads);

/// "a tilt of the platform (1.01(3) rad)", "run 'a', which contradicts the others".
std::string sentence_of(const Explanation& explanation);

/// By how much Akaike's criterion falls.
inline double gain_of(const Explanation& found) {
  return found.chi2_fall - 2 * found.dof;
}

}  // namespace tribotrack::fit::internal
