// How well the disc's position can be known at all from one frame of a synthetic scene.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "vision/scene.h"

namespace tribotrack::vision {

/// The Cramer-Rao bound: no unbiased estimate of the disc's centre c from this frame has a covariance (px^2)
/// below [sum_x grad_c I grad_c I^T / var(I)]^-1, var(I) = read^2 + shot I + 1/12 for rounding to whole
/// levels. Everything but c counts as known: the disc's look and rotation, the platform's picture and its
/// position (the limit for a layered tracker). The whole motion within the exposure is shifted by c.
/// Saturated pixels tell nothing. Infinite where the frame does not determine c. Robinson and Milanfar, IEEE
/// Trans. Image Processing 13 (2004).
Eigen::Matrix2d position_bound(const SceneRenderer& renderer, double time_s, double exposure_s,
                               const std::function<ScenePose(double)>& pose, double lamp_on_share = 0);

/// Its limit for one coordinate of a plain disc at rest on a plain platform under white noise:
///   sigma_d = (sigma / A) sqrt(2 s / (sqrt(pi) R)),
/// A the contrast, s the edge's sd with the pixel's own (s^2 = edge_blur^2 + 1/12), sigma with rounding.
double plain_disc_bound(double radius_px, double contrast, double edge_sd_px, double noise_sd);

}  // namespace tribotrack::vision
