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

#include <vector>

#include "fit/fit_result.h"
#include "fit/measurement.h"

namespace tribotrack::fit::internal {

struct BetweenSlides {
  double mean = 0, sd_of_mean = 0;
  double sd = 0;           ///< tau
  double chi2 = 0;         ///< sum ((mu_i - mean)/s_i)^2 about the mean with weights 1/s_i^2
  int dof = 0;             ///< n - 1
  double p_value = 1;      ///< of chi2: do they differ by chance?
  double information = 0;  ///< sum of weights 1/(s_i^2 + tau^2)
};

/// Of at least one estimate with sd > 0.
BetweenSlides between_slides(const std::vector<Estimate>& slides);

/// The sentence of each slide; warnings of blows and of slides that differ by more than chance; and what the
/// covariance counts. `between` is null where mu1 was not fitted to two
/// slides at least.
void describe_slides(const BetweenSlides* between, FitResult& result);

}  // namespace tribotrack::fit::internal
