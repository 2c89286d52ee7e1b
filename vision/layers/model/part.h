// The part's two pictures and what they leave unexplained, by regression at every place of its grid.
#pragma once

#include "vision/layers/model/ground.h"
#include "vision/layers/model/state.h"

namespace tribotrack::vision {

inline constexpr double kPixelBlend = 1.0 / 12;

/// On a grid of 2 half + 1 places either way, the part's centre in its middle; see state.h.
struct PartPictures {
  int half = 0;
  Picture level;     ///< F, grey levels
  Picture share;     ///< alpha: how much of the ground shows; 1 outside, 0 inside, less than 1 in the shadow
  Picture variance;  ///< V, grey levels^2, beside what is unsure of the ground
  double blend = kPixelBlend;  ///< kappa, px^2: of a square pixel, until the rim tells more
};

/// One regression over the kept windows: at every place u of the grid the frames' levels against the
/// ground's,
///   I_k(c_k + u) = a_k F(u) + b_k alpha(u) g(c_k + u - p_k),   g = G - mean G
/// two unknowns and the variance that is left. A frame weighs less where its ground is hardly known, by V
/// over V + alpha^2 b^2 var G. What `before` says of a slope of the light, of gains of part and ground that
/// differ and of kappa is taken out first. Where the ground shows no texture a weak prior keeps alpha what a
/// blurred rim lets through.
class PartRegression {
 public:
  /// Residuals are taken from `before`, whose levels are also what the sums are formed about.
  PartRegression(const PartPictures& before, const GroundPicture& ground);

  /// A window in its present state. Levels that `before` does not explain within five standard deviations
  /// belong to something else (a hand, a lamp) and are left out if `trim`.
  /// `turned`, if any, is what turns with the part, at the window's angle.
  void add(const KeptWindow& window, bool trim, const Picture* turned = nullptr);
  /// `opaque`: no ground shows inside the rim's blur, whatever light falls on part and ground alike; where
  /// that is not looked for, alpha may take it up there.
  PartPictures solve(double noise_variance, const Picture& prior_share, bool opaque = false) const;

 private:
  Picture share_of_rings(double noise_variance, const Picture& prior_share, bool opaque) const;

  const PartPictures& before_;
  const GroundPicture& ground_;
  Picture share_x_, share_y_;  ///< grad alpha of before
  /// Sums over the windows at every place, with y = I less what before says and g = b (G - mean G):
  /// of 1, the interpolation's share of white noise and, weighted, a^2, a g, g^2, a y, g y, y^2.
  Picture count_, passed_, aa_, ag_, gg_, ay_, gy_, yy_;
  Picture qr_,
      qq_;  ///< with q = b grad alpha . grad g and the residual r of before: of q r and q^2 over its variance
  Picture level_, below_, below_x_, below_y_, unsure_here_;  ///< work space
};

/// What shows of the ground beside a rim of this radius and blur: Phi((rho - R) / s).
Picture blurred_rim(int half, double radius, double blur);

}  // namespace tribotrack::vision
