// Errors that depend on where between the pixels the part lies.
//
// Residuals about the local polynomial are regressed on what the same polynomial leaves of cos 2 pi x,
// sin 2 pi x, cos 2 pi y, sin 2 pi y of the smoothed positions. Only what a motion through several phases
// shows counts: combinations of these that hardly vary within the polynomial's window are left out, for there
// the noise of the positions themselves would explain the residual.
#pragma once

#include <optional>
#include <vector>

#include "vision/audit/frame_to_frame.h"

namespace tribotrack::vision {

/// Of one coordinate: 1 + the mean square of the fitted errors in units of the reported variances, less what
/// noise alone would give, `noise` being its variance in those units: 1 where there is nothing. nullopt where
/// the part does not move through the pixels.
std::optional<MeanSquare> pixel_phase(const std::vector<Stretch>& stretches, const Axis& axis,
                                      const LocalPolynomial& fit, double noise);

}  // namespace tribotrack::vision
