#include "apps/program/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "apps/program/streams.h"

namespace tribotrack::apps {

namespace {

bool may_animate() {
  const char* terminal = std::getenv("TERM");
  return ::isatty(STDERR_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr && terminal != nullptr &&
         std::string(terminal) != "dumb";
}

}  // namespace

Progress::Progress(std::string what, bool quiet)
    : what_(std::move(what)),
      animate_(!quiet && may_animate()),
      begun_(std::chrono::steady_clock::now()),
      last_(begun_) {}

Progress::~Progress() {
  if (shown_) std::fputs("\r\033[K", stderr);
}

void Progress::update(std::int64_t done, std::int64_t total) {
  if (!animate_ || total <= 0) return;
  const std::lock_guard lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (shown_ && done < total && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  shown_ = true;
  const double elapsed = std::chrono::duration<double>(now - begun_).count();
  const double left = done > 0 ? elapsed / static_cast<double>(done) * static_cast<double>(total - done) : 0;
  const std::string line =
      fmt::format("\r\033[K{}: {}/{} ({} %), {:.0f} s left", what_, done, total, 100 * done / total, left);
  std::fputs(line.c_str(), stderr);
  std::fflush(stderr);
}

void StageProgress::update(const std::string& stage, std::size_t done, std::size_t total) {
  if (stage != stage_) {
    stage_ = stage;
    progress_.emplace(stage, quiet_);
  }
  progress_->update(static_cast<std::int64_t>(done), static_cast<std::int64_t>(total));
}

void say(bool quiet, const std::string& text) {
  if (!quiet) print_error(text);
}

}  // namespace tribotrack::apps
