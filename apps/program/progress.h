// Progress of long work, and notes for people, on stderr.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/program/context.h"

namespace tribotrack::apps {

/// How progress is shown: on a terminal one line that is rewritten ten times a second; elsewhere, and where
/// TERM=dumb or NO_COLOR, a plain line every 10 s, so that short work says nothing. For a program that asks
/// by TRIBOTRACK_PROGRESS=json a line {"progress": TEXT, "percent": NUMBER} ten times a second.
enum class ProgressStyle { none, plain, rewritten, json };
ProgressStyle progress_style(bool quiet);

/// One line of progress, shown no more often than its style allows, and taken away at the end.
class ProgressLine {
 public:
  explicit ProgressLine(ProgressStyle style, std::FILE* to = stderr);
  ~ProgressLine() { clear(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  /// May a line be shown now? `last`: nothing comes after it.
  bool is_due(bool last) const;
  void show(std::string_view line, int percent);
  void clear();            ///< what comes next begins at the margin
  double seconds() const;  ///< since it was made

 private:
  ProgressStyle style_;
  std::FILE* to_;
  bool shown_ = false;
  std::chrono::steady_clock::time_point begun_, last_;
};

/// "4000/20000 (20 %), 812 frames/s, 20 s left"; `unit` may be empty.
std::string progress_text(std::int64_t done, std::int64_t total, const std::string& unit, double seconds);

/// Work that is counted, told to whoever the context names as well. Thread-safe.
class Progress {
 public:
  Progress(std::string what, const Context& context, std::string unit = "");
  void update(std::int64_t done, std::int64_t total);

 private:
  std::string what_, unit_;
  const Context& context_;
  std::mutex mutex_;
  ProgressLine line_;
};

/// A note for a person on stderr, unless quiet.
void say(bool quiet, const std::string& text);

// How far the recordings of a campaign are: several at once, of different length.

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
