// Levels at which the fit decides, each defined once.
#pragma once

namespace tribotrack::fit::internal {

/// p of chi^2 below which chance does not explain the residuals: the model or the sigmas are wrong.
inline constexpr double kSurprise = 1e-3;
/// p of chi^2 above which an explanation leaves nothing to explain.
inline constexpr double kExplained = 0.01;
/// Chi^2 of a track's points per degree of freedom: errors of tracking are no larger than three of their sds.
inline constexpr double kMostOfTracking = 9;
/// p of chi^2 below which excess variance between runs is added to the covariance. Milder than kSurprise: a
/// few runs cannot show at that level errors as large as their own sigma.
inline constexpr double kDoubt = 0.05;
/// Probability below which a run contradicts the others.
inline constexpr double kOutlier = 0.01;
/// Rise of chi^2 (three standard deviations) up to which another minimum is reported.
inline constexpr double kNearMinimum = 9;
/// Drop of Akaike's criterion from which another model is preferred.
inline constexpr double kPreferred = 6;
/// Confidence level of all intervals.
inline constexpr double kConfidence = 0.95;

}  // namespace tribotrack::fit::internal
