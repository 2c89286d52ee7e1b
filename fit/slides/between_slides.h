// One friction coefficient from several slides, each with its own, and what is said of it.
//
// Surfaces differ from place to place and from part to part: the slides' mu scatter by more than their sds.
// With mu_i = mu + b_i + e_i, b_i ~ N(0, tau^2), e_i ~ N(0, s_i^2), the mean has weights 1/(s_i^2 + tau^2).
// tau is Paule and Mandel's (J. Res. NBS 87, 377, 1982), the usual choice where laboratories are compared:
// that at which
//   sum (mu_i - mu)^2/(s_i^2 + tau^2) = n - 1,
// 0 where the left side is less without it. It needs no normal b_i, equals the restricted likelihood's where
// the s_i are alike, and makes the interval of Hartung and Knapp (Stat. Med. 20, 3875, 2001) - Student's t
// with n - 1 degrees of freedom times the scatter actually seen - the plain one: mu -+ t / sqrt(sum of
// weights).
#pragma once

#include <optional>
#include <vector>

#include "fit/fit_result.h"
#include "fit/measurement.h"
#include "fit/track_table.h"

namespace tribotrack::fit::internal {

struct BetweenSlides {
  double mean = 0;
  double sd = 0;           ///< tau
  double chi2 = 0;         ///< sum ((mu_i - mean)/s_i)^2 about the mean with weights 1/s_i^2
  int dof = 0;             ///< n - 1
  double p_value = 1;      ///< of chi2: do they differ by chance?
  double information = 0;  ///< sum of weights 1/(s_i^2 + tau^2): 1/sd^2 of the mean
};

/// Of at least one estimate with sd > 0.
BetweenSlides between_slides(const std::vector<Estimate>& slides);

/// The sentence of each slide; warnings of blows and of slides that differ by more than chance; and what the
/// covariance counts. `between` is null where mu1 was not fitted to two
/// slides at least.
void describe_slides(const BetweenSlides* between, FitResult& result);

// Errors of a slide's track that hang together more than the track says.
//
// A track whose standard deviations are right in size, or too large, may still take errors for independent
// that last over many frames: a coder that lags, a lens, a camera that is not still. Their mean does not fall
// with the number of frames. The residuals show it: their correlation from frame to frame lies above that
// which the track's own slow errors give by more than chance does, 1/sqrt(n) (Bartlett 1946), and from one
// frame to the next they differ less than the track says. Then the errors are those that the residuals show.
// Residuals that hang together beyond errors that differ as told are another matter: a law that does not
// hold, or scatter that is added.

/// Residuals along a slide, one a point used.
struct SlideResiduals {
  std::vector<double> time;   ///< s
  std::vector<double> value;  ///< m
};

struct ShownErrors {
  double own_sd = 0;  ///< m, of each point by itself
  SlowError slow;
};

/// What differs from one frame to the next, (e_k+1 - e_k)^2 / 2, is each point's own. The rest of the
/// residuals' variance is slow, made up for what the parabola of the slide has taken of it and, as few
/// independent values tell it, widened as Student's t is; it lasts until the correlation has fallen to 1/e of
/// that at the next frame. nullopt where the residuals do not
/// contradict the track.
std::optional<ShownErrors> shown_errors(const TrackTable& track, const SlideResiduals& residuals);

/// The track with these instead of its own.
void take_errors(const ShownErrors& shown, TrackTable& track);

}  // namespace tribotrack::fit::internal
