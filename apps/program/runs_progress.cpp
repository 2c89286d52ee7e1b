#include "apps/program/runs_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tribotrack::apps {

RunsProgress::RunsProgress(std::vector<std::uintmax_t> sizes, ProgressStyle style, std::FILE* to)
    : line_(style, to) {
  for (const std::uintmax_t size : sizes) runs_.push_back({std::max(1.0, static_cast<double>(size))});
}

void RunsProgress::update(std::size_t index, std::int64_t done, std::int64_t total) {
  const std::lock_guard lock(mutex_);
  runs_[index].frames = done;
  runs_[index].share = total > 0 ? static_cast<double>(done) / static_cast<double>(total) : 0;
  show();
}

void RunsProgress::finish(std::size_t index) {
  const std::lock_guard lock(mutex_);
  Run& run = runs_[index];
  if (run.frames == 0) run.size = 0;
  run.share = 1;
  ++finished_;
  show();
}

void RunsProgress::show() {
  if (!line_.is_due(finished_ == runs_.size())) return;
  double done = 0, all = 0;
  std::int64_t frames = 0;
  for (const Run& run : runs_) {
    done += run.size * run.share;
    all += run.size;
    frames += run.frames;
  }
  const double share = all > 0 ? done / all : 1, seconds = line_.seconds();
  std::string text = fmt::format("runs: {}/{} ({:.0f} %)", finished_, runs_.size(), std::floor(100 * share));
  if (frames > 0 && seconds > 0)
    text += fmt::format(", {:.0f} frames/s, {:.0f} s left", static_cast<double>(frames) / seconds,
                        seconds * (1 - share) / share);
  line_.show(text);
}

}  // namespace tribotrack::apps
