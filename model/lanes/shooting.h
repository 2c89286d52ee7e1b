// The periodic sliding motion by multiple shooting: parts of one cycle travel side by side.
#pragma once

#include <optional>

#include "model/steady_orbit.h"

namespace tribotrack::model::internal {

/// The cycle is cut at its switches and into eight parts in all, one in each lane of SlideLanes; Newton's
/// method on the parts' starts makes each end where the next begins (Stoer & Bulirsch, Introduction to
/// Numerical Analysis, 7.3.5; Ascher, Mattheij & Russell, Numerical Solution of Boundary Value
/// Problems, 4.3). Good to 1e-13 of the drive's A w. Nothing where the drive is no circle, friction does not
/// switch, the part stops or nearly does, or Newton's method does not get there at once: that the orbit
/// attracts makes it the only one, so that whatever is found is right.
std::optional<SteadyOrbit> shoot(const Scenario& scenario);

}  // namespace tribotrack::model::internal
