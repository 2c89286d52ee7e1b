// Errors of a slide's track that hang together more than the track says.
//
// A track whose standard deviations are right in size, or too large, may still take errors for independent
// that last over many frames: a coder that lags, a lens, a camera that is not still. Their mean does not fall
// with the number of frames. The residuals show it: their correlation from frame to frame lies above that
// which the track's own slow errors give by more than chance does, 1/sqrt(n) (Bartlett 1946), and from one
// frame to the next they differ less than the track says. Then the errors are those that the residuals show.
// Residuals that hang together beyond errors that differ as told are another matter: a law that does not
// hold, or scatter that is added.
#pragma once

#include <optional>
#include <vector>

#include "fit/track_table.h"

namespace tribotrack::fit::internal {

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
