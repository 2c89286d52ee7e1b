// Rehearsing a coder: what did it do to this track?
//
// Where the coder is known by its own word (x264 writes its settings into the stream; MJPEG and MPEG-4 hold
// their quantisers), the tracked motion is done once more with everything known: a disc of the part's size,
// levels and blur, on ground of the same level and texture and with the same mark, moves along the track,
// smoothed as far as the track's own errors allow. These pictures are coded the same way, decoded and tracked
// by the same program, and the errors of that track are what the coder, and the tracker on its pictures, make
// of such a motion:
//   rms by frame type     -> the standard deviations, times 1.1 (rehearsed errors are 0.94 to 1.22 of real
//                            ones), but never less than the recording itself supports
//   e = -a (x - mean x) - T dx/dt + noise  -> attenuation a and delay T of the part and of the mark; at the
//                            angular frequency w they show cos wt as Re (1 - a - i w T) exp(i wt)
// The part's own texture and the shadow are left out: a coder decides by the strongest edge of a block.
//
//   TrackResult result = track(*source, options);
//   rehearse(*source, options, result);
//   if (result.summary.coded) std::cout << result.summary.coded->part->delay << " s late\n";
#pragma once

#include <optional>
#include <string>

#include "vision/frame_source.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

/// What to expect of a coder before anything is tracked, of a disc of 30 px radius with a rim of this
/// contrast, grey levels: of such recordings errors of motion faster than 0.2 px a frame were 0.3 steps over
/// the contrast where other frames predict (0.26 to 0.39; x264, mpeg4), 0.08 where every frame is coded by
/// itself (0.06 to 0.10); slow motion comes late by up to d0 = 0.71 dead_zone step / contrast (dead_zone.h).
struct CodingForecast {
  double error_px = 0;
  double late_px = 0;
  std::string advice;
};

/// Nothing where the coder does not tell its steps.
std::optional<CodingForecast> forecast(const Coder& coder, double contrast);

/// Throws InputError for a lossy recording whose coder is not known well enough (Coder::known), before an
/// hour of tracking.
void require_rehearsable(const SourceInfo& recording);

/// Widens or narrows the standard deviations of ok points and fills TrackSummary::coded. Nothing to do for a
/// recording that no lossy coder made. Throws InputError for a coder that is not known well enough
/// (Coder::known), for a part that is no disc, and where too little of the track is ok.
void rehearse(FrameSource& source, const TrackOptions& options, TrackResult& result);

}  // namespace tribotrack::vision
