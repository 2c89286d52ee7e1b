#include "vision/audit/sample.h"

#include <cstddef>

namespace tribotrack::vision {

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
