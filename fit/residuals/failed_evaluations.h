// Where a fit tried values at which the model has no motion.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

namespace tribotrack::fit::internal {

/// Thread-safe.
class FailedEvaluations {
 public:
  struct Failure {
    Eigen::VectorXd values;  ///< of the unknowns, physical
    std::string reason;
  };
  void add(const Eigen::VectorXd& values, const std::string& reason) {
    const std::lock_guard lock(mutex_);
    ++count_;
    if (kept_.size() < kMostKept) kept_.push_back({values, reason});
  }
  std::size_t count() const {
    const std::lock_guard lock(mutex_);
    return count_;
  }
  std::vector<Failure> kept() const {  ///< the first of them
    const std::lock_guard lock(mutex_);
    return kept_;
  }

 private:
  static constexpr std::size_t kMostKept = 10'000;
  mutable std::mutex mutex_;
  std::size_t count_ = 0;
  std::vector<Failure> kept_;
};

}  // namespace tribotrack::fit::internal
