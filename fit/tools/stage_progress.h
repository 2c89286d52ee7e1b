// Progress of a stage of the fit.
#pragma once

#include <cstddef>
#include <functional>
#include <mutex>

#include "fit/estimate.h"

namespace tribotrack::fit::internal {

/// Counts the items done and reports them. Thread-safe.
class Stage {
 public:
  Stage(const FitOptions& options, const char* name, std::size_t total = 0)
      : progress_(options.progress), name_(name), total_(total) {}
  void expect(std::size_t more) {
    const std::lock_guard lock(mutex_);
    total_ += more;
  }
  void done(std::size_t more = 1) {
    if (!progress_) return;
    const std::lock_guard lock(mutex_);
    done_ += more;
    progress_(name_, done_, total_);
  }

 private:
  std::function<void(const char* stage, std::size_t done, std::size_t total)> progress_;
  const char* name_;
  std::size_t total_, done_ = 0;
  std::mutex mutex_;
};

}  // namespace tribotrack::fit::internal
