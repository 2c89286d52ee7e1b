// Recordings that a camera or a copy writes into a folder, each handed out once it is finished.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <vector>

namespace tribotrack::apps {

/// What tells one state of a recording from the next: of a folder of pictures, all of them.
struct FileState {
  std::uintmax_t bytes = 0;
  std::int64_t files = 0;
  std::filesystem::file_time_type changed = std::filesystem::file_time_type::min();
  bool operator==(const FileState&) const = default;
};

class Arrivals {
 public:
  struct Options {
    double settled_s = 2;   ///< without change: finished, where it opens
    double give_up_s = 60;  ///< without change, and it does not open: handed out as it is, for the message
    double poll_s = 0.25;
  };

  /// Throws InvalidInput where the folder is none.
  Arrivals(std::filesystem::path folder, const Options& options);

  /// Recordings finished since the last call, or finished again after a change. Waits at most `patience_s`
  /// for the first. A recording is finished when it has not changed for a while and opens as a whole: a
  /// header that promises more than the file holds does not.
  std::vector<std::filesystem::path> next(double patience_s);

  /// Recordings there that are not finished.
  std::vector<std::filesystem::path> unfinished() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Recording {
    FileState state;
    Clock::time_point since;  ///< when this state was first seen
    bool handed_out = false;  ///< in this state
  };
  void look();
  bool is_finished(const std::filesystem::path& path, const Recording& recording) const;

  std::filesystem::path folder_;
  Options options_;
  std::map<std::filesystem::path, Recording> recordings_;
};

}  // namespace tribotrack::apps
