// The rate at which a sliding disc turns, from the angle seen in its track.
#pragma once

#include <cstddef>
#include <optional>

#include "fit/problem.h"

namespace tribotrack::fit::internal {

/// At the slide's first point, by least squares of the angles seen on the law's
///   theta(t) = theta_0 + turned(t; omega, b),
/// with theta_0, omega and the bearing b unknown: an even disc that bears on its face up to e^b of its
/// radius. `mu` and `velocity` are the slide's; the sd counts what the angles scatter beyond their own.
/// nullopt where fewer than eight points show an angle, or the radius is not known.
std::optional<DiscSpin> slide_spin(const TrajectoryRun& run, double mu, const Eigen::Vector2d& velocity);
/// The same with mu and velocity as a first look at the positions has them, without spin.
std::optional<DiscSpin> first_slide_spin(const TrajectoryRun& run);

}  // namespace tribotrack::fit::internal
