// The second pass: disc over platform, both pictures learnt from the recording itself.
//
// A first pass with a single template sees the platform through the rim and the light change along the path;
// both look like motion. This pass keeps a bounded number of windows spread over the recording, learns from
// them the platform's picture, the rim's profile and the disc's picture (see layered_state.h), and then
// measures every frame again. Reads the recording at most twice, forwards, and of a recording that is decoded
// mostly what the first pass has kept (layered_keeping.h); memory does not grow with its length.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "vision/frame_source.h"
#include "vision/layers/registration/registration.h"

namespace tribotrack::vision {

/// A frame as the first pass left it.
struct FirstPassFrame {
  std::int64_t index = 0;
  Point centre;
  double theta = 0;
  Point ground;  ///< the platform's displacement since the first frame
};

/// Frames spread over a recording that the layers are learnt from, as far as the part is seen in them.
inline constexpr std::int64_t kLearningFrames = 128;
/// Whether the frame at this place (0 .. total - 1) of those analysed is one of them.
bool is_learning_frame(std::int64_t place, std::int64_t total);
/// Px about the part's centre that are looked at in every frame.
double layered_reach(double radius, double blur);

struct LayeredOptions {
  Circle disc;                              ///< in the first frame
  double blur = 1;                          ///< of its rim, px
  bool turning = false;                     ///< its texture shows its rotation
  double noise_variance = 1;                ///< a start
  double top_level = 255;                   ///< at which pixels clip
  bool standing_light = true;               ///< look for it; a coder's errors look alike
  double excess = 0;                        ///< residual of the first pass beyond it, grey levels rms
  bool motion_known = false;                ///< else the pass looks whether the platform rests
  std::int64_t first_index = 0, total = 0;  ///< of the frames analysed; 0: not known
  /// Kept for learning: the layers' own noise adds 1 / windows to the variance.
  int max_windows = kLearningFrames;
  double max_kept_bytes = 140e6;
  std::function<void(std::int64_t done)> progress;  ///< frames measured
};

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
