// The best possible accuracy of the disc's position in one frame of a synthetic scene.
//
// The yardstick for every tracker: its scatter over many noisy renderings, divided by this bound, is 1 at
// best.
//
//   const SceneRenderer renderer(scene);
//   const auto pose = [](double) { return ScenePose{{160.3, 120.7}, 0, {}}; };
//   const Eigen::Matrix2d bound = position_bound(renderer, 0, 20e-6, pose);
//   std::cout << "at best " << std::sqrt(bound(0, 0)) << " px in x\n";
//
// For a plain disc at rest on a plain platform under white noise of standard deviation sigma, contrast A,
// radius R and edge of standard deviation s (with the pixel's own, s^2 = edge_blur^2 + 1/12) it is, for one
// coordinate,
//   sigma_d = (sigma / A) sqrt(2 s / (sqrt(pi) R)).
#pragma once

#include <Eigen/Core>
#include <functional>

#include "vision/scene.h"

namespace tribotrack::vision {

/// The Cramer-Rao bound: no unbiased estimate of the disc's centre c from this frame has a covariance (px^2)
/// below [sum_x grad_c I grad_c I^T / var(I)]^-1, var(I) = read^2 + shot I + 1/12 for rounding to whole
/// levels. Everything but c is taken as known: the disc's look and rotation, the platform's picture and its
/// position (the limit for a layered tracker). The whole motion within the exposure is shifted by c.
/// Saturated pixels carry no information. Infinite where the frame does not determine c. Robinson and
/// Milanfar, IEEE Trans. Image Processing 13 (2004).
Eigen::Matrix2d position_bound(const SceneRenderer& renderer, double time_s, double exposure_s,
                               const std::function<ScenePose(double)>& pose, double lamp_on_share = 0);

}  // namespace tribotrack::vision
