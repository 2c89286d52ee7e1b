// Finding a round part in a picture and measuring its centre and radius.
//
// Search: every strong edge pixel votes for centres along its gradient, one radius at a time (Hough), on a
// pyramid of pictures so that radii of 8 to 400 px cost the same. Measurement: the blurred rim
//   I(rho, phi) = O(phi) + (A(phi) - O(phi)) Phi((R - s^2 / (2 R) - rho) / s)
// fitted to every pixel near the rim by Levenberg-Marquardt; Phi is the normal distribution function, s the
// blur with the pixel's own 1/12 px^2, A the level inside (quadratic across the disc), O that outside
// (linear). R is the radius of the sharp disc before the blur: the s^2 / (2 R) is what a Gaussian blur in the
// plane does to a curved edge, to the second order in s / R (the third is below 2e-5 px at R = 30 px, s = 0.8
// px).
#pragma once

#include <optional>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

struct DiscFit {
  Circle circle;
  /// Px; from how differently sectors of the rim pull at it, and never less than that of the noise alone.
  double radius_sd = 0;
  double blur = 0;      ///< s, px
  double contrast = 0;  ///< level inside minus outside
  double coverage = 0;  ///< share of the rim at which the edge is seen, 0 .. 1
  double residual_rms = 0;
  double score = 0;    ///< for comparing candidates
  double outside = 0;  ///< mean level beyond the rim
  /// Part of radius_sd, px: what an uneven level inside (a highlight) does to the radius in all pictures
  /// alike.
  double common_sd = 0;
};

/// What a fit is for: the place of a disc in one picture, or the radius in the mean of many.
enum class RimUse { place, mean_radius };

/// Measures the disc near `guess`, up to `capture` px wrong in centre and radius. nullopt where the rim does
/// not support a circle there (coverage below one half, or the fit walks away).
std::optional<DiscFit> fit_disc(const Picture& picture, const Circle& guess, double capture,
                                RimUse use = RimUse::place);

/// px that centre and radius may lie from the guess of a fit with that capture.
double fit_reach(double capture);

/// Of a disc seen clearly and all round: no other of that radius scores higher.
double largest_score(double radius);

struct DiscSearch {
  double min_radius = 6;
  double max_radius = 420;
  std::optional<Circle> keep_out;  ///< nothing that touches this circle is reported
  double min_coverage = 0.7;
  double max_blur_share = 0.25;  ///< of the radius
  double min_clarity = 3;        ///< contrast over what the fit leaves
  /// Smaller ones need not be found beside the best, in shares of its radius: then the search, from coarse to
  /// fine, ends where finer levels of the pyramid can show no others. 0: all are looked for.
  double beside_best = 0;
};

/// Round things in the picture, best first.
std::vector<DiscFit> find_discs(const Picture& picture, const DiscSearch& search, int max_count = 5);

}  // namespace tribotrack::vision
