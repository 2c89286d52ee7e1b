// Progress of a stage of the fit.
#pragma once

#include <chrono>
#include <cmath>
#include <cstddef>
#include <functional>
#include <mutex>

#include "fit/estimate.h"

namespace tribotrack::fit::internal {

/// Counts the items done and reports them, and says when they have taken too long. Thread-safe.
class Stage {
 public:
  using Seconds = std::chrono::duration<double>;
  Stage(const FitOptions& options, const char* name, std::size_t total = 0,
        Seconds longest = Seconds(HUGE_VAL))
      : progress_(options.progress), name_(name), total_(total), longest_(longest) {}
  bool late() const { return Seconds(std::chrono::steady_clock::now() - begun_) > longest_; }
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
  Seconds longest_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::mutex mutex_;
};

}  // namespace tribotrack::fit::internal
