// The audit: does the recording itself bear out the standard deviations that tracking reports?
//
// Those come from a model of the pictures. The audit asks what no model of the pictures enters:
//   halves           do complementary halves of the pixels agree on the position (halves.h)?
//   high frequency   do positions scatter from frame to frame as they should (high_frequency())?
// An error that all pixels share and that is slow shows in none of them.
#pragma once

#include <optional>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// From the audited frames, in order, and the track that they belong to.
Audit audit(const std::vector<AuditFrame>& frames, const Track& track);

/// Nothing reports less than the audit finds: widens the covariances of ok points and what the summary says
/// of slow errors, and keeps the audit there, with a warning where it calls for one.
void apply(const Audit& found, Track& track, TrackSummary& summary);

// Noise from frame to frame, by differences of high order.
//
// The p-th difference of white noise has the variance C(2p, p) sigma^2: 6, 70, 924 for p = 2, 4, 6. A motion
// that is slow against the frame rate adds less and less to it from order to order. So the lowest order that
// finds no more than the next one is free of the motion; where none is, the motion is too fast for this and
// nothing is said.
//
// For white noise the covariance of two such estimates, relative, is 2/n C(2p + 2q, p + q) / (C(2p, p)
// C(2q, q)) from n differences (Vandermonde's identity for the products of their coefficients), which says
// when two orders differ.

/// One coordinate of the track over a stretch of consecutive frames that are ok.
struct TrackStretch {
  std::vector<double> position, sigma;  ///< px; as reported
};

std::vector<TrackStretch> stretches(const Track& track, double TrackPoint::*position,
                                    double TrackPoint::*sigma);

struct HighFrequency {
  MeanSquare noise;  ///< against the reported variances
  int order = 0;     ///< p
};

/// Single outliers are left out. nullopt where the motion is too fast or there are fewer than 24 differences.
std::optional<HighFrequency> high_frequency(const std::vector<TrackStretch>& stretches);

}  // namespace tribotrack::vision
