// The second pass: disc over background, both pictures learnt from the recording itself.
//
// To a first pass with a single template the background seen through the rim and the light that changes along
// the path look like motion. This pass keeps a bounded number of windows spread over the recording, learns
// from them the background's picture, the rim's profile and the disc's picture (see model/state.h), and then
// measures every frame again. Reads the recording at most twice, forwards; of a decoded recording mostly what
// the first pass has cached (FramesForLayers). Memory does not grow with its length.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vision/frame_source.h"
#include "vision/layers/model/first_pass.h"
#include "vision/layers/registration/registration.h"
#include "vision/stages/stage_clock.h"

namespace tribotrack::vision {

struct LayeredResult {
  /// One per frame handed in, nullopt where the model does not hold (too near the border, something in the
  /// way). Empty if nothing could be learnt; see why_not.
  std::vector<std::optional<LayeredFix>> fixes;
  std::string why_not;
  NoiseLaw noise;
  SlowError slow_error;                        ///< correlated errors of the fixes; in the covariances
  double disc_radius = 0, disc_radius_sd = 0;  ///< of the averaged picture, px; 0 where it shows no circle
  int windows = 0;
  double ground_texture = 0;      ///< of the platform's picture, grey levels rms
  double crossed_share = 0;       ///< of the ground at rest: showed something else than usual
  double curved_light_share = 0;  ///< of the windows, see illumination_test.h
  int light_rounds = 0;           ///< in which static illumination was learnt; 0: there is none
  double light_moved = 0;         ///< shift of the windows by taking it out, px rms without the mean
  double light_unsettled = 0;     ///< likewise by the last round; in the covariances
  double rim_excess = 0;  ///< variance of the rim's residuals over the noise's, minus 1; in the covariances
};

/// A scene that the model does not fit is no error, see why_not. Throws InputError for a recording that
/// cannot be read.
LayeredResult layered_pass(FrameSource& source, const std::vector<FirstPassFrame>& frames,
                           const LayeredOptions& options, StageClock& clock);

}  // namespace tribotrack::vision
