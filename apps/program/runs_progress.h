// How far the recordings of a campaign are: several at once, of different length.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "apps/program/progress.h"

namespace tribotrack::apps {

/// "runs: 12/500 (3 %), 1250 frames/s, 310 s left". The share done is of the recordings' sizes: that of the
/// frames of those under way is in it, that of runs which took no work (current ones) is not. Thread-safe.
class RunsProgress {
 public:
  /// `sizes`: of each run, bytes or any other measure of its work.
  RunsProgress(std::vector<std::uintmax_t> sizes, ProgressStyle style, std::FILE* to = stderr);
  /// Of run `index` this many frames of so many have been worked on.
  void update(std::size_t index, std::int64_t done, std::int64_t total);
  void finish(std::size_t index);

 private:
  void show();

  struct Run {
    double size = 0, share = 0;
    std::int64_t frames = 0;
  };
  std::mutex mutex_;
  std::vector<Run> runs_;
  std::size_t finished_ = 0;
  ProgressLine line_;
};

}  // namespace tribotrack::apps
