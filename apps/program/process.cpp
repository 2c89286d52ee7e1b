#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>

#include "apps/program/called.h"
#include "apps/program/context.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"

namespace tribotrack::apps {

int threads_to_use(const Context& context) {
  if (context.threads > 0) return context.threads;
  int count = 1;
  cpu_set_t cpus;
  if (sched_getaffinity(0, sizeof cpus, &cpus) == 0) count = CPU_COUNT(&cpus);
  if (const char* slurm = std::getenv("SLURM_CPUS_PER_TASK"))
    if (const int given = std::atoi(slurm); given > 0) count = std::min(count, given);
  std::ifstream quota_file("/sys/fs/cgroup/cpu.max");
  std::string quota;
  double period = 0;
  if (quota_file >> quota >> period && quota != "max" && period > 0)
    count = std::min(count, std::max(1, static_cast<int>(std::atof(quota.c_str()) / period)));
  return std::max(1, count);
}

void Context::doubt(ExitCode code, const std::string& sentence) {
  exit_code = code;
  called ? called->doubts.push_back(sentence) : complain(sentence);
}

namespace {

[[noreturn]] void fail() {
  throw WriteError(fmt::format("write error: {}", std::strerror(errno)));
}

}  // namespace

std::string printable(std::string_view text) {
  std::string shown(text);
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const auto c = static_cast<unsigned char>(shown[k]);
    const bool wide = c == 0xC2 && k + 1 < shown.size() &&
                      (static_cast<unsigned char>(shown[k + 1]) & 0xE0) == 0x80;  // U+0080 ...
    if ((c < 0x20 && c != '\n' && c != '\t') || c == 0x7F || wide) shown[k] = '?';
    if (wide) shown.erase(k + 1, 1);
  }
  return shown;
}

void print_text(std::string_view text) {
  const std::string shown = printable(text);
  errno = 0;
  if (std::fwrite(shown.data(), 1, shown.size(), stdout) != shown.size()) fail();
}

void flush_output() {
  errno = 0;
  if (std::fflush(stdout) != 0) fail();
}

void print_error(std::string_view line) {
  const std::string text = printable(line) + "\n";
  std::fwrite(text.data(), 1, text.size(), stderr);
}

void complain(std::string_view message) {
  print_error(fmt::format("tribotrack: {}", message));
}

void occupy_standard_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream)
    if (::fcntl(stream, F_GETFD) == -1 && errno == EBADF) {
      // Writing to a stdout opened for reading fails: results that nobody receives are an error.
      const int opened = ::open("/dev/null", stream == STDOUT_FILENO ? O_RDONLY : O_RDWR);
      if (opened != stream && opened >= 0) {
        ::dup2(opened, stream);
        ::close(opened);
      }
    }
}

namespace {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kRewrite{100};
constexpr std::chrono::seconds kPlain{10};

}  // namespace

ProgressStyle progress_style(bool quiet) {
  if (quiet) return ProgressStyle::none;
  if (const char* asked = std::getenv("TRIBOTRACK_PROGRESS"); asked && std::string_view(asked) == "json")
    return ProgressStyle::json;
  const char* terminal = std::getenv("TERM");
  const bool rewrites = ::isatty(STDERR_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr &&
                        terminal != nullptr && std::string_view(terminal) != "dumb";
  return rewrites ? ProgressStyle::rewritten : ProgressStyle::plain;
}

ProgressLine::ProgressLine(ProgressStyle style, std::FILE* to)
    : style_(style), to_(to), begun_(steady_clock::now()), last_(begun_) {}

void ProgressLine::clear() {
  if (shown_ && style_ == ProgressStyle::rewritten) std::fputs("\r\033[K", to_);
  if (shown_ && style_ == ProgressStyle::json) show("", 100);
  shown_ = false;
}

bool ProgressLine::is_due(bool last) const {
  if (style_ == ProgressStyle::none) return false;
  if (style_ == ProgressStyle::plain) return steady_clock::now() - last_ >= kPlain;
  return !shown_ || last || steady_clock::now() - last_ >= kRewrite;
}

void ProgressLine::show(std::string_view line, int percent) {
  last_ = steady_clock::now();
  shown_ = true;
  const std::string shown = printable(line);
  const std::string text = style_ == ProgressStyle::rewritten ? "\r\033[K" + shown
                           : style_ == ProgressStyle::json
                               ? fit::Json{{"progress", shown}, {"percent", percent}}.dump() + "\n"
                               : shown + "\n";
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

Progress::Progress(std::string what, const Context& context, std::string unit)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      context_(context),
      line_(progress_style(context.quiet)) {}

void Progress::update(std::int64_t done, std::int64_t total) {
  context_.tell(what_, done, total);
  if (total <= 0) return;
  const std::lock_guard lock(mutex_);
  if (line_.is_due(done >= total))
    line_.show(fmt::format("{}: {}", what_, progress_text(done, total, unit_, line_.seconds())),
               static_cast<int>(100 * done / total));
  if (done >= total) line_.clear();  // notes may come before this object goes
}

void say(bool quiet, const std::string& text) {
  if (!quiet) print_error(text);
}

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
  line_.show(text, static_cast<int>(100 * share));
}

}  // namespace tribotrack::apps
