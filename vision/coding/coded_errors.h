// What a lossy coder adds to the errors of a track that its own pictures do not show.
//
// The scatter of clusters and halves (vision/layers/measuring.h, vision/audit) finds what blocks
// do to the position each by itself. What all blocks of the rim do together it cannot see. Where a block is
// predicted from another frame, and the displacement since is not worth coding up to d0 (rim_coding.h), the
// part stays behind: it is seen through a play of half width b, and while it moves its error is b against the
// direction of motion, b^2 / 2 along either axis of the plane, and all of the rim shares it. Measured,
// b = 0.58 d0, so
//   var = (s + m / 8) d0^2 / 6,
// s the share of the rim predicted from the same place of another frame, m that predicted from elsewhere,
// where the vector follows the part. On recordings of a disc (x264, crf 15 to 28, presets veryfast and
// medium, with and without B frames, mpeg4; motion of 0.05 to 1 px a frame) errors are 0.5 to 1.5 of the
// standard deviations that come out: two-way prediction and finer decisions leave less.
//
// Where the coder tells neither steps nor blocks (HEVC, VP9, AV1) the measured law of such recordings,
//   sd = (1.4 + 3 s) times that of blocks,
// is used with s = 1.
//
// And the two passes are compared: pictures learnt from a coded recording hold the coder's own, which stand
// still where the part moves by less than its edge is wide, and hold it back. What the second pass sees of
// the displacement otherwise than the first, by a share a, is an error a (x - mean x).
#pragma once

#include <vector>

#include "vision/coding/rim_coding.h"
#include "vision/picture.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// What is known of a coded track before it is widened.
struct CodedTrack {
  Coder coder;
  std::vector<WatchedFrame> frames;
  std::int64_t first_index = 0;  ///< in the source, of the track's first point
  Point part_unnoticed = {};     ///< unnoticed_motion() of the part, px for a dead zone of one grey level
  Point mark_unnoticed = {};     ///< of the mark
  double passes_differ = 0;      ///< a
};

/// Share of a displacement by which `other` sees it larger than `track`, as far as it is beyond two standard
/// deviations; 0 else. Over the points that are ok in both.
double displacement_differs(const Track& track, const Track& other);

/// Widens the covariances of ok points; fills what is known of the coding.
void widen_for_coding(const CodedTrack& coded, Track& track, TrackSummary& summary);

}  // namespace tribotrack::vision
