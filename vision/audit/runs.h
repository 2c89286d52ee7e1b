// Which frames are audited: runs of consecutive ones, spread over the recording.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/audit/split.h"

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

/// The same where nobody knows yet in how many frames the part will be seen: runs are thinned out to every
/// second, fourth, ... one as they grow too many.
class AuditSample {
 public:
  /// Whether the next frame in which the part is seen is to be audited.
  bool wanted() const { return run() % stride_ == 0; }
  /// The part was seen in one more frame, audited or not.
  void seen(const std::optional<AuditFrame>& frame);
  /// All of a short track, else between 128 and 256.
  const std::vector<AuditFrame>& frames() const { return frames_; }

 private:
  std::int64_t run() const { return seen_ / kAuditRun; }
  void thin_out();

  std::int64_t seen_ = 0, stride_ = 1;
  std::vector<AuditFrame> frames_;
  std::vector<std::int64_t> runs_;  ///< of each of these
};

}  // namespace tribotrack::vision
