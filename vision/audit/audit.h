// The audit: does the recording itself bear out the standard deviations that tracking reports?
//
// Those come from a model of the pictures. The audit asks what no model of the pictures enters:
//   halves           do complementary halves of the pixels agree on the position (halves.h)?
//   high frequency   do positions scatter from frame to frame as they should (frame_to_frame.h)?
// An error that all pixels share and that is slow shows in none of them.
#pragma once

#include <string>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// From the audited frames, in order, and the track that they belong to.
Audit audit(const std::vector<AuditFrame>& frames, const Track& track);

/// Nothing reports less than the audit finds: widens the covariances of ok points and what the summary says
/// of slow errors, and keeps the audit there, with a warning where it calls for one.
void apply(const Audit& found, Track& track, TrackSummary& summary);

/// One sentence where a ratio exceeds 1.3, else empty.
std::string audit_warning(const Audit& found);

}  // namespace tribotrack::vision
