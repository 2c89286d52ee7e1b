// The second pass, the part's own pictures over the ground's, learnt from the recording itself: whether it
// pays, and what it changes in a track.
//
// To a first pass with a single template the ground seen through the rim, the part's shadow and whatever
// turns in it look like motion. This pass keeps a bounded number of windows spread over the recording, learns
// from them the ground's picture and the part's (model/model.h), and then measures every frame again. Reads
// the recording forwards, once for what is learnt and once to measure; of a decoded recording mostly what the
// first pass has cached (read_again()). Memory does not grow with its length.
#pragma once

#include <string>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/stages/first_pass_result.h"
#include "vision/stages/stage_clock.h"

namespace tribotrack::vision {

/// Measures every frame again over the platform's own picture where that pays: positions, standard deviations
/// and correlations of the track's ok points change, never their status. `shown` frames go to
/// TrackOptions::debug.
PassOutcome layered_stage(FrameSource& source, const FirstPassResult& first, const TrackOptions& options,
                          const std::vector<ShownFrame>& shown, StageClock& clock, Track& track);

/// Frames spread over a recording that the layers are learnt from, as far as the part is seen in them. The
/// layers' own noise adds 1 / kLearningFrames to the variance.
inline constexpr std::int64_t kLearningFrames = 128;
/// Whether the frame at this place (0 .. total - 1) of those analysed is one of them.
bool is_learning_frame(std::int64_t place, std::int64_t total);
/// Half width of the part's grid, px: the part with its rim and its shadow.
int layered_half(double radius, double blur);

/// Of a frame in which the part is seen: what the second pass, and the rotation by rings, will read again. A
/// window about the part, or all of a frame that the layers are probably learnt from; empty for nothing.
Rect read_again(const FirstPassResult& first, Layers layers, std::int64_t index, const Point& centre,
                const Rect& bounds);

}  // namespace tribotrack::vision
