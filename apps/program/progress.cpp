#include "apps/program/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "apps/program/streams.h"

namespace tribotrack::apps {

namespace {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kRewrite{100};
constexpr std::chrono::seconds kPlain{10};

}  // namespace

ProgressStyle progress_style(bool quiet) {
  if (quiet) return ProgressStyle::none;
  const char* terminal = std::getenv("TERM");
  const bool rewrites = ::isatty(STDERR_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr &&
                        terminal != nullptr && std::string_view(terminal) != "dumb";
  return rewrites ? ProgressStyle::rewritten : ProgressStyle::plain;
}

ProgressLine::ProgressLine(ProgressStyle style, std::FILE* to)
    : style_(style), to_(to), begun_(steady_clock::now()), last_(begun_) {}

ProgressLine::~ProgressLine() {
  if (shown_ && style_ == ProgressStyle::rewritten) std::fputs("\r\033[K", to_);
}

bool ProgressLine::is_due(bool last) const {
  if (style_ == ProgressStyle::none) return false;
  if (style_ == ProgressStyle::plain) return steady_clock::now() - last_ >= kPlain;
  return !shown_ || last || steady_clock::now() - last_ >= kRewrite;
}

void ProgressLine::show(std::string_view line) {
  last_ = steady_clock::now();
  shown_ = true;
  const std::string text =
      style_ == ProgressStyle::rewritten ? fmt::format("\r\033[K{}", line) : fmt::format("{}\n", line);
  std::fputs(text.c_str(), to_);
  std::fflush(to_);
}

double ProgressLine::seconds() const {
  return std::chrono::duration<double>(steady_clock::now() - begun_).count();
}

std::string progress_text(std::int64_t done, std::int64_t total, const std::string& unit, double seconds) {
  std::string text = fmt::format("{}/{} ({} %)", done, total, 100 * done / total);
  if (done <= 0 || !(seconds > 0)) return text;
  const double rate = static_cast<double>(done) / seconds;
  if (!unit.empty()) text += fmt::format(", {:.{}f} {}/s", rate, rate < 10 ? 1 : 0, unit);
  return text + fmt::format(", {:.0f} s left", static_cast<double>(total - done) / rate);
}

Progress::Progress(std::string what, bool quiet, std::string unit)
    : what_(std::move(what)), unit_(std::move(unit)), line_(progress_style(quiet)) {}

void Progress::update(std::int64_t done, std::int64_t total) {
  if (total <= 0) return;
  const std::lock_guard lock(mutex_);
  if (line_.is_due(done >= total))
    line_.show(fmt::format("{}: {}", what_, progress_text(done, total, unit_, line_.seconds())));
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
