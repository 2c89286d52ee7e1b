// What the first pass leaves to the second, beside the track.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/picture.h"
#include "vision/track.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

struct FrameRange {
  std::int64_t first = 0, last = 0;  ///< indices, both included
  std::int64_t count() const { return last - first + 1; }
};

/// From the recording's own numbers. Throws InputError where it does not hold them.
FrameRange frames_to_analyse(const FrameSource& source, const TrackOptions& options);

struct FirstPassResult {
  std::int64_t first_index = 0;     ///< of the track's first point in the source
  std::int64_t total = 0;           ///< frames analysed
  Circle disc;                      ///< in the first frame
  double blur = 0;                  ///< of its rim, px; 0 where the part is not a disc
  double contrast = 0;              ///< across it, grey levels; 0 where the part is not a disc
  double limit_px = 0;              ///< Cramer-Rao bound of a coordinate by the template
  bool turning = false;             ///< the part's texture shows its rotation
  bool texture_seen = false;        ///< in the first frame there is a texture that would show it
  std::vector<double> theta;        ///< that rotation, rad, one per point; 0 where not ok
  std::vector<double> sigma_theta;  ///< its standard deviation; 0 where it was not measured
  std::vector<bool> by_rim;         ///< the template was not confirmed: by the rim alone, theta as predicted
  std::vector<AuditFrame> audited;  ///< frames whose halves were compared, none measured by the rim
  std::vector<double> residual;     ///< grey levels rms, one per point; 0 where not ok
  double noise_variance = 0;
  double ground_texture = 0;  ///< about the part in the first frame, grey levels rms beyond the noise
  double excess = 0;          ///< median residual beyond the noise, grey levels rms
};

/// A frame as the first pass left it.
struct FirstPassFrame {
  std::int64_t index = 0;
  Point centre;
  Point ground = {};  ///< the platform's displacement since the first frame
};

struct SeenFrames {
  std::vector<FirstPassFrame> frames;
  std::vector<std::size_t> places;  ///< in the track
};

/// The frames in which the part was found and, if asked for, the marker where there is one. `first_index` is
/// that of the track's first point in the source.
inline SeenFrames seen_frames(const Track& track, std::int64_t first_index, bool with_marker = false) {
  SeenFrames seen;
  const MarkerPoint* origin = nullptr;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok || (with_marker && track.has_marker && !p.marker)) continue;
    FirstPassFrame f{first_index + static_cast<std::int64_t>(k), {p.x, p.y}};
    if (p.marker) {
      if (!origin) origin = &*p.marker;
      f.ground = {p.marker->x - origin->x, p.marker->y - origin->y};
    }
    seen.frames.push_back(f);
    seen.places.push_back(k);
  }
  return seen;
}

/// What a pass that measures the frames again found out, for the track's summary.
struct PassOutcome {
  bool done = false;  ///< else the track is as it was, and only the plan is filled
  std::vector<PlanStage> plan;
  std::vector<std::string> warnings;
  double limit_px = 0;                ///< median standard deviation of a coordinate
  double slow_sd = 0, slow_time = 0;  ///< see TrackSummary
  std::vector<AuditFrame> audited;    ///< frames whose halves were compared
};

// What is shown to TrackOptions::debug: which frames, and in which range of levels.

struct ShownFrame {
  std::int64_t index = 0;  ///< in the source; of status ok
  std::string why;
};

/// In order. `residual` rms of each point of the track, whose first has index `first_index`. None without
/// TrackOptions::debug. Throws InputError where a requested frame was not analysed.
std::vector<ShownFrame> frames_to_show(const Track& track, std::int64_t first_index,
                                       const std::vector<double>& residual, const TrackOptions& options);

/// Both are drawn in the range of the first one's levels.
void share_range(StagePicture& from, StagePicture& with);

/// a - b, NaN where either is.
Picture difference(const Picture& a, const Picture& b);

}  // namespace tribotrack::vision
