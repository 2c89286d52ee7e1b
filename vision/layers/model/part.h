// The part's two pictures and what they leave unexplained, by regression at every place of its grid.
#pragma once

#include <memory>
#include <span>

#include "vision/layers/model/ground.h"
#include "vision/layers/model/state.h"

namespace tribotrack::vision {

class PartTileSums;

inline constexpr double kPixelBlend = 1.0 / 12;

/// On a grid of 2 half + 1 places either way, the part's centre in its middle; see state.h.
struct PartPictures {
  int half = 0;
  Picture level;     ///< F, grey levels
  Picture share;     ///< alpha: how much of the ground shows; 1 outside, 0 inside, less than 1 in the shadow
  Picture variance;  ///< V, grey levels^2, beside what is unsure of the ground
  double blend = kPixelBlend;  ///< kappa, px^2: of a square pixel, until the rim tells more
};

/// One regression over the kept windows: at every place u of the grid the frames' levels against what F and
/// alpha are multiplied by,
///   I_k(c_k + u) = a F(u) + h alpha(u),   a = a_k (1 + s_k . u),   h = b_k G(c_k + u - p_k) - a mean G
/// two unknowns and the variance that is left. A frame weighs less where its ground is hardly known, by V
/// over V + alpha^2 b^2 var G. What `before` says of kappa is taken out first. Where the ground shows no
/// texture a weak prior keeps alpha what a blurred rim lets through.
class PartRegression {
 public:
  /// Residuals are taken from `before`, whose levels are also what the sums are formed about.
  PartRegression(const PartPictures& before, const GroundPicture& ground);
  ~PartRegression();

  /// Windows in their present states. Levels that `before` does not explain within five standard deviations
  /// belong to something else (a hand, a lamp) and are left out if `trim`. The sums do not depend on the
  /// number of threads.
  void add(WindowSpan windows, bool trim, int threads = 1);
  /// No ground shows inside the rim's blur: alpha is 0 there, and nowhere below 0 or above 1.1.
  PartPictures solve(double noise_variance, const Picture& prior_share) const;

 private:
  const PartPictures& before_;
  const GroundPicture& ground_;
  std::unique_ptr<PartTileSums> sums_;
};

/// What shows of the ground beside a rim of this radius and blur: Phi((rho - R) / s).
Picture blurred_rim(int half, double radius, double blur);

}  // namespace tribotrack::vision
