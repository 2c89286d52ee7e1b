// The second pass: the part's own pictures over the ground's, learnt from the recording itself.
//
// To a first pass with a single template the ground seen through the rim, the part's shadow and whatever
// turns in it look like motion. This pass keeps a bounded number of windows spread over the recording, learns
// from them the ground's picture and the part's (see state.h), and then measures every frame again. Reads the
// recording forwards, once for what is learnt and once to measure; of a decoded recording mostly what the
// first pass has cached (FramesReadAgain). Memory does not grow with its length.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/frame_source.h"
#include "vision/layers/first_pass.h"
#include "vision/layers/registration/registration.h"
#include "vision/stages/stage_clock.h"

namespace tribotrack::vision {

struct LayeredResult {
  /// One per frame handed in, nullopt where the model does not hold (too near the border, something in the
  /// way). Empty if nothing could be learnt; see why_not.
  std::vector<std::optional<LayeredFix>> fixes;
  std::string why_not;
  double disc_radius = 0, disc_radius_sd = 0;  ///< of the averaged picture, px; 0 where it shows no circle
  int windows = 0, rounds = 0;
  std::string noise;          ///< of the first pass and of this, in words
  double ground_texture = 0;  ///< of the platform's picture, grey levels rms
  bool ground_known = true;   ///< it shows the same in most frames, displacements taken into account
  double crossed_share = 0;   ///< of the ground: showed something else than usual
  /// Errors that neighbouring frames share, in the covariances: standard deviation of a coordinate, px, and
  /// over how many frames they stay alike.
  double slow_sd = 0, slow_frames = 0;
  std::vector<AuditFrame> audited;  ///< frames whose halves were compared
};

/// A scene that the model does not fit is no error, see why_not. Throws InputError for a recording that
/// cannot be read.
LayeredResult layered_pass(FrameSource& source, const std::vector<FirstPassFrame>& frames,
                           const LayeredOptions& options, StageClock& clock);

}  // namespace tribotrack::vision
