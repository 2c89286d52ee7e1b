// Millimetres per pixel.
#pragma once

#include <span>

#include "vision/track.h"

namespace tribotrack::vision {

/// From the part's true diameter D and its radius R in the picture, that of the sharp disc before the blur of
/// optics and pixels (fit_disc allows for what blur does to a curved rim):
///   mm_per_px = D / (2 R),   (sd / mm_per_px)^2 = (sd(D) / D)^2 + (sd(R) / R)^2.
/// A part whose own edge is rounded shows the radius at which its edge is half as bright: then that is what D
/// must be measured to, and diameter_sd_mm says how well.
Scale scale_from_diameter(double diameter_mm, double radius_px, double radius_sd_px,
                          double diameter_sd_mm = 0);

/// As the user gave it, with the sd the user gave.
Scale given_scale(double mm_per_px, double sd = 0);

/// Several recordings of one part by one camera that did not move.
struct PooledScale {
  Scale scale;            ///< sd: what the mean does not know of itself, and what all recordings share
  double chi2 = 0;        ///< of the recordings' own scales about their mean, count - 1 degrees of freedom
  int count = 0;          ///< recordings
  double scatter = 0;     ///< between recordings, beyond their own sds; 0 where these explain chi2
  bool one_scale = true;  ///< no scatter, or one that rims on differing ground explain (kRimScatter)
};

/// Scatter between recordings, of the scale, up to which it is that of measuring: the ground that a rim lies
/// on pulls its radius by some hundredths of a pixel. A camera that is moved changes its scale by more.
inline constexpr double kRimScatter = 5e-4;

/// The mean weighted by 1 / (sd^2 + scatter^2), sd without what they share: relative sd `common_relative_sd`
/// (the part's true diameter), which each of `scales` holds in its sd and which no averaging takes out. Where
/// chance gives such a chi2 in fewer than 1 of 1000 campaigns the scatter is estimated by moments
/// (DerSimonian, Laird 1986). Scales without an sd must be equal. Throws std::invalid_argument for an empty
/// list.
PooledScale pooled_scale(std::span<const Scale> scales, double common_relative_sd = 0);

}  // namespace tribotrack::vision
