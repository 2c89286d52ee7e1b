// Progress of long work, and notes for people, on stderr.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

namespace tribotrack::apps {

/// On a terminal one line that is rewritten, with an estimate of the time left; elsewhere nothing until it is
/// done, and nothing at all when quiet. Thread-safe.
class Progress {
 public:
  Progress(std::string what, bool quiet);
  ~Progress();
  void update(std::int64_t done, std::int64_t total);

 private:
  std::string what_;
  bool animate_;
  bool shown_ = false;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point begun_, last_;
};

/// The same for work of several stages, one after the other.
class StageProgress {
 public:
  explicit StageProgress(bool quiet) : quiet_(quiet) {}
  void update(const std::string& stage, std::size_t done, std::size_t total);

 private:
  bool quiet_;
  std::string stage_;
  std::optional<Progress> progress_;
};

/// A note for a person on stderr, unless quiet.
void say(bool quiet, const std::string& text);

}  // namespace tribotrack::apps
