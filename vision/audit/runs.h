// Which frames are audited: runs of consecutive ones, spread over the recording.
#pragma once

#include <cstdint>
#include <vector>

namespace tribotrack::vision {

/// Long enough to tell what changes from frame to frame from what changes slowly.
inline constexpr std::int64_t kAuditRun = 8;
/// A ratio of standard deviations pooled over three splits of two coordinates is then known to 1.8 %.
inline constexpr std::int64_t kAuditFrames = 256;

/// Frames [first, last].
struct AuditRun {
  std::int64_t first = 0, last = 0;
};

/// Of frames [first, first + total), in order: all of a short recording.
std::vector<AuditRun> audit_runs(std::int64_t first, std::int64_t total);

/// Whether the frame lies in one of the runs.
bool in_audit(const std::vector<AuditRun>& runs, std::int64_t index);

}  // namespace tribotrack::vision
