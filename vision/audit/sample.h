// Which frames are audited where nobody knows yet in how many the part will be seen: runs of consecutive
// ones, thinned out to every second, fourth, ... run as they grow too many (audit_runs() where it is known).
#pragma once

#include <optional>
#include <vector>

#include "vision/audit/runs.h"
#include "vision/audit/split.h"

namespace tribotrack::vision {

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
