// How far a stage of the fit is.
#pragma once

#include <cstddef>
#include <mutex>

#include "fit/estimate.h"

namespace tribotrack::fit::internal {

/// Counts what is done of what is known to be to do, and tells it. Thread-safe.
class Stage {
 public:
  Stage(const FitOptions& options, const char* name, std::size_t total = 0)
      : options_(options), name_(name), total_(total) {}
  void expect(std::size_t more) {
    const std::lock_guard lock(mutex_);
    total_ += more;
  }
  void done(std::size_t more = 1) {
    if (!options_.progress) return;
    const std::lock_guard lock(mutex_);
    done_ += more;
    options_.progress(name_, done_, total_);
  }

 private:
  const FitOptions& options_;
  const char* name_;
  std::size_t total_, done_ = 0;
  std::mutex mutex_;
};

}  // namespace tribotrack::fit::internal
