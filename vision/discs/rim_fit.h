// The blurred rim of a disc fitted to the pixels near it:
//   I(rho, phi) = O(phi) + (A(phi) - O(phi)) Phi((R - s^2 / (2 R) - rho) / s),
// see disc_detection.h.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "vision/discs/disc_detection.h"

namespace tribotrack::vision {

constexpr std::size_t kSectors = 36;  ///< of the rim

/// x, y, R, s, then the level inside as a quadratic in (u, v) = ((x, y) - centre) / R: 1, u, v, u^2, uv, v^2,
/// and outside as 1, u, v, u^2 + v^2. A highlight's slope towards the rim would else be taken for a part of
/// the rim; a slope on one side only would take up what the edge's profile differs from a Gaussian's.
constexpr int kRimParameters = 14;
constexpr int kRimInside = 4, kRimOutside = 10;
using RimParameters = Eigen::Matrix<double, kRimParameters, 1>;
using RimCovariance = Eigen::Matrix<double, kRimParameters, kRimParameters>;

struct RimPixels {
  std::vector<double> x, y, level, weight;
};

/// Those within `band` px of the circle, with weight 1.
RimPixels rim_pixels(const Picture& picture, const Circle& circle, double band);

/// Whether the disc is large enough for the curvature of its levels to be fitted. It makes the fit of a small
/// disc noisier; the mean over many frames bears that, and without curvature would be off in all of them
/// alike.
bool rim_curves(const RimParameters& parameters, RimUse use);

/// The band that holds the blurred edge and enough of either side, px.
double rim_band(const RimParameters& parameters, bool curved);

struct RimFit {
  RimParameters p = RimParameters::Zero();
  RimCovariance covariance = RimCovariance::Zero();
  double residual_rms = 0;
  /// What the residuals in each sector of the rim (about 5 px long) pulled the radius by, px; empty for small
  /// discs.
  std::vector<double> sector_pull;
};

/// Levenberg-Marquardt, first all pixels alike, then with Tukey's weights. Changes the pixels' weights.
RimFit fit_rim(RimPixels& pixels, const RimParameters& start, bool curved);

}  // namespace tribotrack::vision
