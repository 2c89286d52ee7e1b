// The platform's own texture as its marker: which window of it yields its motion best?
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// A window that nothing covers and that can be registered.
struct TexturePatch {
  Rect window;
  double limit_px = 0;  ///< Cramer-Rao bound of its worse direction from one frame, px
};

struct TexturePatchSearch {
  double noise_variance = 1.0 / 12;
  std::vector<Circle> covered;  ///< at any time of the recording: nothing of the window may lie there
  int margin_px = 10;           ///< kept from the picture's border: the window moves
  double worst_limit_px = 0.3;  ///< a window that is located worse than this is no use
};

/// The square window with the smallest bound sigma / sqrt(smaller eigenvalue of sum grad f grad f^T), the
/// part of the gradients that is noise taken off, over all sizes and places on a grid. nullopt with a reason.
std::optional<TexturePatch> best_texture_patch(const Picture& first, const TexturePatchSearch& search,
                                               std::string& why_not);

}  // namespace tribotrack::vision
