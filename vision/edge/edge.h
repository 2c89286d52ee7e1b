// Where a round part is, by its edge alone, blind to what lamps and metal do inside and outside of it.
//
// Levels in frame k along the ray at azimuth phi, s px beyond the rim (RayGrid), are
//   I_k(phi, s) = M(phi, s) - grad M . d_k + fields + noise,
// M their mean over frames, d_k how far the centre lies from where the frame was sampled, fields what changes
// along the ray (rays.h): Gaussian processes that end or begin at the edge, with variances of their own in
// each band of time (split_bands()) and each part of the rim. d_k follows by generalised least squares,
//   d_b = -A_b sum_phi grad M^T S_b^-1 B_b[I - M],  A_b = (sum_phi grad M^T S_b^-1 grad M)^-1,  d = sum_b
//   d_b,
// B_b the band. Its covariance is that of the scores of sixteen sectors among each other: it holds whatever
// moves the sectors, as long as it does not move them together as a shift does.
//
// M, the gradient and the variances are learnt from a bounded number of frames, in rounds; the rim's optics
// from M and, once positions have settled, from the slow band, whose fields end at the same edge.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "vision/edge/radius.h"
#include "vision/edge/rays.h"
#include "vision/stages/stages.h"
#include "vision/track.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

struct EdgeOptions {
  double radius = 0;          ///< px, known to about a pixel
  double noise_variance = 1;  ///< of a pixel, grey levels^2
  int threads = 1;            ///< the result is the same for any number
};

struct EdgeTrack {
  /// One per frame handed in, nullopt where not all of the rim lies in the picture; slow errors are in the
  /// covariances. Empty if nothing could be learnt.
  std::vector<std::optional<Remeasured>> fixes;
  std::size_t learnt_from = 0;  ///< frames
  RimOptics optics;
  double radius = 0;       ///< of the edge, px
  double slow_sd = 0;      ///< of a coordinate's errors in the slow band, px: part of the covariances
  double slow_frames = 0;  ///< over how many frames they stay alike
};

/// Frames in order, with centres that are known to a pixel. Throws InputError for a recording that cannot be
/// read.
EdgeTrack track_edge(FrameSource& source, const SeenFrames& frames, const EdgeOptions& options);

// The edge in bands of time as a stage of tracking: whether it pays, and whether it does better than
// pictures.

struct EdgeOutcome : PassOutcome {
  std::optional<OuterEdge> outer;  ///< where it was looked for
};

/// Measures the ok points of `track` again by the part's edge, if noise alone would allow clearly less than
/// the error of a coordinate that the track and its audit state (`stated`, px), or if the part turns visibly
/// and the edge disagrees with the track in the first and the last frames. Positions and covariances change
/// if the edge errs by less than the track: by `stated`, or by what the edge's own errors leave of their
/// difference. Where a wide chamfer parts the outer edge from what turns on the part's top it is the edge
/// that is followed.
EdgeOutcome edge_stage(FrameSource& source, const FirstPassResult& first, const TrackOptions& options,
                       StageClock& clock, double stated, Track& track);

}  // namespace tribotrack::vision
