#include "vision/audit/runs.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

namespace tribotrack::vision {

std::vector<AuditRun> audit_runs(std::int64_t first, std::int64_t total) {
  if (total <= 0) return {};
  if (total <= kAuditFrames) return {{first, first + total - 1}};
  constexpr std::int64_t kRuns = kAuditFrames / kAuditRun;
  std::vector<AuditRun> runs;
  for (std::int64_t k = 0; k < kRuns; ++k) {
    const std::int64_t begin = first + k * (total - kAuditRun) / (kRuns - 1);
    runs.push_back({begin, begin + kAuditRun - 1});
  }
  return runs;
}

bool in_audit(const std::vector<AuditRun>& runs, std::int64_t index) {
  const auto after =
      std::upper_bound(runs.begin(), runs.end(), index,
                       [](std::int64_t frame, const AuditRun& run) { return frame < run.first; });
  return after != runs.begin() && index <= std::prev(after)->last;
}

void AuditSample::seen(const std::optional<AuditFrame>& frame) {
  if (frame && wanted()) {
    frames_.push_back(*frame);
    runs_.push_back(run());
  }
  ++seen_;
  if (static_cast<std::int64_t>(frames_.size()) > kAuditFrames) thin_out();
}

void AuditSample::thin_out() {
  stride_ *= 2;
  std::size_t kept = 0;
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    if (runs_[k] % stride_ != 0) continue;
    frames_[kept] = frames_[k];
    runs_[kept++] = runs_[k];
  }
  frames_.resize(kept, frames_.front());
  runs_.resize(kept);
}

}  // namespace tribotrack::vision
