#include "apps/watch/arrivals.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "apps/program/errors.h"
#include "apps/text/input_file.h"
#include "vision/frame_source.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

constexpr double kBetweenTries = 0.5;  ///< s, to open a recording that did not

/// Nothing where the path is no recording, or vanishes while it is looked at.
std::optional<FileState> state_of(const fs::path& path) {
  std::error_code error;
  const auto add = [&](FileState& state, const fs::path& file) {
    const std::uintmax_t bytes = fs::file_size(file, error);
    const auto changed = fs::last_write_time(file, error);
    if (error) return;
    state.bytes += bytes;
    ++state.files;
    state.changed = std::max(state.changed, changed);
  };
  FileState state;
  if (fs::is_directory(path, error)) {
    for (fs::directory_iterator at(path, error), end; !error && at != end; at.increment(error))
      if (names_a_picture(at->path())) add(state, at->path());
  } else if (names_a_recording(path)) {
    add(state, path);
  }
  if (error || state.files == 0) return std::nullopt;
  return state;
}

bool opens_whole(const fs::path& path) {
  try {
    vision::open_source(path);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace

Arrivals::Arrivals(fs::path folder, const Options& options) : folder_(std::move(folder)), options_(options) {
  if (!fs::is_directory(folder_))
    throw InvalidInput(
        fmt::format("{}: is no folder; give the one that the camera writes into", folder_.string()));
  // Where the system has no notifier left, polling does.
  notifier_ = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (notifier_ >= 0) inotify_add_watch(notifier_, folder_.c_str(), IN_CLOSE_WRITE | IN_MOVED_TO | IN_CREATE);
}

Arrivals::~Arrivals() {
  if (notifier_ >= 0) close(notifier_);
}

void Arrivals::hear() {
  if (notifier_ < 0) return;
  alignas(inotify_event) std::array<char, 16384> buffer{};
  for (;;) {
    const ssize_t length = read(notifier_, buffer.data(), buffer.size());
    if (length <= 0) return;
    for (ssize_t at = 0; at < length;) {
      inotify_event event{};
      std::memcpy(&event, buffer.data() + at, sizeof event);
      if (event.len > 0 && (event.mask & (IN_CLOSE_WRITE | IN_MOVED_TO)) != 0)
        closed_.push_back(folder_ / (buffer.data() + at + sizeof event));
      at += static_cast<ssize_t>(sizeof event + event.len);
    }
  }
}

void Arrivals::look() {
  const auto now = Clock::now();
  hear();
  std::map<fs::path, Recording> there;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    const fs::path& path = entry.path();
    if (path.filename().string().starts_with('.')) continue;
    const auto state = state_of(path);
    if (!state) continue;
    const auto known = recordings_.find(path);
    Recording& recording = there[path];
    if (known != recordings_.end() && known->second.state == *state)
      recording = known->second;
    else
      recording = {*state, now, false, false, {}, false};
    // Heard of before the state was read: what is there now is what was closed, or a later close will be
    // heard.
    if (std::ranges::count(closed_, path) > 0) recording.closed = true;
  }
  closed_.clear();
  recordings_ = std::move(there);
}

bool Arrivals::is_finished(const fs::path& path, Recording& recording) const {
  const auto seconds_since = [](Clock::time_point then) {
    return std::chrono::duration<double>(Clock::now() - then).count();
  };
  const double unchanged = seconds_since(recording.since);
  if (!recording.closed && unchanged < options_.settled_s) return false;
  if (!recording.opens && seconds_since(recording.tried) >= kBetweenTries) {
    recording.opens = opens_whole(path);
    recording.tried = Clock::now();
  }
  return recording.opens || unchanged >= options_.give_up_s;
}

void Arrivals::wait(double seconds) const {
  pollfd heard{notifier_, POLLIN, 0};
  poll(&heard, notifier_ >= 0 ? 1 : 0, static_cast<int>(1000 * std::min(seconds, options_.poll_s)));
}

std::vector<fs::path> Arrivals::next(double patience_s) {
  const auto until = Clock::now() + std::chrono::duration<double>(patience_s);
  for (;;) {
    look();
    std::vector<fs::path> finished;
    for (auto& [path, recording] : recordings_)
      if (!recording.handed_out && is_finished(path, recording)) {
        recording.handed_out = true;
        finished.push_back(path);
      }
    const double left = std::chrono::duration<double>(until - Clock::now()).count();
    if (!finished.empty() || left <= 0) return finished;
    wait(left);
  }
}

std::vector<fs::path> Arrivals::unfinished() const {
  std::vector<fs::path> paths;
  for (const auto& [path, recording] : recordings_)
    if (!recording.handed_out) paths.push_back(path);
  return paths;
}

}  // namespace tribotrack::apps
