// The part's two pictures and what they leave unexplained, by regression at every place of its grid.
#pragma once

#include "vision/layers/ground.h"
#include "vision/layers/state.h"

namespace tribotrack::vision {

/// On a grid of 2 half + 1 places either way, the part's centre in its middle; see state.h.
struct PartPictures {
  int half = 0;
  Picture level;     ///< F, grey levels
  Picture share;     ///< alpha: how much of the ground shows; 1 outside, 0 inside, less than 1 in the shadow
  Picture variance;  ///< V, grey levels^2
};

/// One regression over the kept windows: at every place u of the grid the frames' levels against the ground's,
///   I_k(c_k + u) = a_k (1 + s_k . u) F(u) + b_k alpha(u) (G(c_k + u - p_k) - mean G),
/// two unknowns and the variance that is left. Where the ground shows no texture a weak prior keeps alpha what
/// a blurred rim lets through.
class PartRegression {
 public:
  /// Residuals are taken from `before`, whose levels are also what the sums are formed about.
  PartRegression(const PartPictures& before, const GroundPicture& ground);

  /// A window in its present state. Levels that `before` does not explain within five standard deviations
  /// belong to something else (a hand, a lamp) and are left out if `trim`.
  void add(const KeptWindow& window, bool trim);
  PartPictures solve(double noise_variance, const Picture& prior_share) const;

 private:
  const PartPictures& before_;
  const GroundPicture& ground_;
  double mean_square_ground_ = 0;
  /// Sums over the windows at every place, with y = I less a (1 + s . u) F of before and g = b (G - mean G): of
  /// 1, the interpolation's share of white noise, a^2, a g, g^2, a y, g y, y^2 and b^2 var G.
  Picture count_, passed_, aa_, ag_, gg_, ay_, gy_, yy_, unsure_;
  Picture level_, below_, unsure_here_;  ///< work space
};

/// What shows of the ground beside a rim of this radius and blur: Phi((rho - R) / s).
Picture blurred_rim(int half, double radius, double blur);

}  // namespace tribotrack::vision
