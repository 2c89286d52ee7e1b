// The second pass: disc over platform, both pictures learnt from the recording itself.
//
// A first pass with a single template sees the platform through the rim and the light change along the path;
// both look like motion. This pass keeps a bounded number of windows spread over the recording, learns from
// them the platform's picture, the rim's profile and the disc's picture (see layered_state.h), and then
// measures every frame again. Reads the recording at most twice, forwards, and of a recording that is decoded
// mostly what the first pass has kept (layered_keeping.h); memory does not grow with its length.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vision/frame_source.h"
#include "vision/layers/model/first_pass.h"
#include "vision/layers/registration/registration.h"

namespace tribotrack::vision {

struct LayeredResult {
  /// One per frame handed in, nullopt where the model does not hold (too near the border, something in the
  /// way). Empty if nothing could be learnt; see why_not.
  std::vector<std::optional<LayeredFix>> fixes;
  std::string why_not;
  NoiseLaw noise;
  SlowError slow_error;                        ///< what the errors of the fixes share; is in the covariances
  double disc_radius = 0, disc_radius_sd = 0;  ///< of the averaged picture, px; 0 where it shows no circle
  int windows = 0;
  double ground_texture = 0;   ///< of the platform's picture, grey levels rms
  double crossed_share = 0;    ///< of the ground at rest, that showed something else than usual
  double bent_share = 0;       ///< of the windows, see bent_light.h
  int light_rounds = 0;        ///< in which light that stands in the picture was learnt; 0: there is none
  double light_moved = 0;      ///< what taking it out moved the windows by, px rms, their mean not counted
  double light_unsettled = 0;  ///< likewise the last round: is in the covariances
  double rim_excess =
      0;  ///< variance of the rim's residuals over the noise's, minus 1; is in the covariances
};

/// Never throws for what the scene is like; InputError for a recording that cannot be read.
LayeredResult layered_pass(FrameSource& source, const std::vector<FirstPassFrame>& frames,
                           const LayeredOptions& options);

}  // namespace tribotrack::vision
