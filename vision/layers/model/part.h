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

/// One regression over kept windows in their present states: at every place u of the grid the frames' levels
/// against what F and alpha are multiplied by,
///   I_k(c_k + u) = a F(u) + h alpha(u),   a = a_k (1 + s_k . u),   h = b_k G(c_k + u - p_k) - a mean G
/// two unknowns and the variance that is left. A frame weighs less where its ground is hardly known, by V
/// over V + alpha^2 b^2 var G. What `before` says of kappa is taken out first, and residuals are taken from
/// it. Levels that it does not explain within five standard deviations belong to something else (a hand, a
/// lamp) and are left out if `trim`. Where the ground shows no texture a weak prior keeps alpha what a
/// blurred rim lets through: no ground shows inside the rim's blur, where alpha is 0, and nowhere is it below
/// 0 or above 1.1. The same for any number of threads.
PartPictures learn_pictures(const PartPictures& before, const GroundPicture& ground, WindowSpan windows,
                            bool trim, double noise_variance, const Picture& prior_share, int threads = 1);

/// What shows of the ground beside a rim of this radius and blur: Phi((rho - R) / s).
Picture blurred_rim(int half, double radius, double blur);

}  // namespace tribotrack::vision
