// What a lossy coder adds to the errors of a track that its own pictures do not show.
//
// The scatter of clusters and halves (vision/layers, vision/audit) finds what blocks
// do to the position each by itself. What all blocks of the rim do together it cannot see. Where a block is
// predicted from another frame, and the displacement since is not worth coding up to d0 (unnoticed_motion()),
// the part stays behind: it is seen through a play of half width b, and while it moves its error is b against
// the direction of motion, b^2 / 2 along either axis of the plane, and all of the rim shares it. Measured, b
// = 0.58 d0, so
//   var = (s + m / 8) d0^2 / 6,
// s the share of the rim predicted from the same place of another frame, m that predicted from elsewhere,
// where the vector follows the part. On recordings of a disc (x264, crf 15 to 28, presets veryfast and
// medium, with and without B frames, mpeg4; motion of 0.05 to 1 px a frame) errors are 0.5 to 1.5 of the
// standard deviations that come out: two-way prediction and finer decisions leave less.
//
// Where the coder tells neither steps nor blocks (HEVC, VP9, AV1) the measured law of such recordings,
//   sd = (1.4 + 3 s) times that of blocks,
// is used with s = 1; and all errors count as play of b = sqrt2 sd, also those that the audit has found. On a
// ray-traced platform through x265 and SVT-AV1 its amplitude is then 0.1 to 2.4 sd off.
//
// And the two passes are compared: pictures learnt from a coded recording hold the coder's own, which stand
// still where the part moves by less than its edge is wide, and hold it back. What the second pass sees of
// the displacement otherwise than the first, by a share a, is an error a (x - mean x).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/frame_source.h"
#include "vision/picture.h"
#include "vision/track.h"

namespace tribotrack::vision {

// How a coder stored the rim of a disc in one frame.
//
// A displacement along x is told by the edges across it, so a place of the rim at the angle phi counts by
// cos^2 phi for x and by sin^2 phi for y.

struct RimCoding {
  char type = '?';        ///< of the frame
  double step = 0;        ///< of the quantiser at the rim, grey levels; 0 unknown
  Point still = {0, 0};   ///< share that is predicted from the same place of another frame, for x and y
  Point moving = {0, 0};  ///< share that is predicted from elsewhere
};

RimCoding rim_coding(const CodedFrame& frame, const Circle& rim);

// What the coder did to the part and to the platform's mark, frame by frame, gathered while the recording is
// decoded for the first time.

struct WatchedFrame {
  std::int64_t index = 0;  ///< in the source
  RimCoding part;
  RimCoding mark;  ///< the round mark, or all of the picture where the ground serves as one
};

/// Of the frame that was read just now: the part, and the round mark where one was seen. `recording` is the
/// one that decodes, not what caches it.
WatchedFrame watched(const FrameSource& recording, std::int64_t index, const Circle& part,
                     const std::optional<Circle>& mark);

// How far a part can move before its coder notices.
//
// Where another frame predicts a block, what the prediction leaves is transformed, and coefficients below
// z steps of the quantiser are dropped (z: Coder::dead_zone). A displacement d along x leaves d dI/dx. So
// nothing of it is coded up to
//   d0 = z step / m,   m = max_k |DCT(dI/dx)_k|,
// with the mean of m over the blocks about the rim, weighed by their information (dI/dx)^2: the blocks that
// tell most of a displacement are the first to notice it. For a straight edge of contrast c along the grid,
// blurred by less than half a block, the largest coefficient of its slope is sqrt(2) c in blocks of 4 x 4 and
// 8 x 8 alike: d0 = 0.59 step / c for x264.

/// px that a part can move along x and y unnoticed, for a dead zone of one grey level. Of what lies within
/// `margin` px of the circle's line; negative: all of the circle's inside as well. 0 where nothing shows.
Point unnoticed_motion(const Picture& picture, const Circle& rim, double margin);

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
