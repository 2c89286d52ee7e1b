#include "apps/open/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include "apps/program/errors.h"

namespace tribotrack::apps {

std::string command_line(const Words& arguments) {
  std::string line = "tribotrack";
  for (const std::string& word : arguments) {
    const bool plain = !word.empty() && word.find_first_not_of(
                                            "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                            "0123456789_-./,:=+%@") == word.npos;
    std::string quoted;
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string{c};
    line += plain ? " " + word : " '" + quoted + "'";
  }
  return line;
}

namespace {

/// Two ends of a pipe; closed where they are still open.
struct Ends {
  int read = -1, write = -1;
  Ends() {
    std::array<int, 2> both{};
    if (::pipe2(both.data(), O_CLOEXEC) != 0) throw std::runtime_error(std::strerror(errno));
    read = both[0];
    write = both[1];
  }
  Ends(const Ends&) = delete;
  Ends& operator=(const Ends&) = delete;
  ~Ends() {
    close_end(read);
    close_end(write);
  }
  static void close_end(int& end) {
    if (end >= 0) ::close(end);
    end = -1;
  }
};

Words environment_of_child() {
  Words words = {"TRIBOTRACK_PROGRESS=json"};
  for (char** word = environ; *word != nullptr; ++word) words.emplace_back(*word);
  return words;
}

std::vector<char*> pointers(Words& words) {
  std::vector<char*> all;
  for (std::string& word : words) all.push_back(word.data());
  all.push_back(nullptr);
  return all;
}

/// After fork(), in a process of many threads: calls that are safe in signal handlers, no others.
[[noreturn]] void become(char* const* arguments, char* const* environment, const char* folder, int out,
                         int err) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nothing = ::open("/dev/null", O_RDONLY);
  if (nothing < 0 || ::dup2(nothing, 0) < 0 || ::dup2(out, 1) < 0 || ::dup2(err, 2) < 0 ||
      ::chdir(folder) != 0)
    ::_exit(127);
  ::close_range(3, ~0U, 0);
  ::execve("/proc/self/exe", arguments, environment);
  ::_exit(127);
}

}  // namespace

Printed run_itself(const Words& arguments, const std::filesystem::path& folder,
                   const std::function<void(Stream, std::string_view)>& heard,
                   const std::function<void(int)>& started) {
  Ends out, err;
  Words words = arguments, environment = environment_of_child();
  words.insert(words.begin(), "tribotrack");
  const std::vector<char*> argv = pointers(words), envp = pointers(environment);
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) throw std::runtime_error(fmt::format("no process is to be had: {}", std::strerror(errno)));
  if (child == 0) {
    if (::getppid() != parent) ::_exit(127);
    become(argv.data(), envp.data(), folder.c_str(), out.write, err.write);
  }
  if (started) started(child);
  Ends::close_end(out.write);
  Ends::close_end(err.write);
  Printed printed;
  std::array<pollfd, 2> ends{pollfd{out.read, POLLIN, 0}, pollfd{err.read, POLLIN, 0}};
  std::array<char, 65536> buffer{};
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    if (::poll(ends.data(), ends.size(), -1) < 0 && errno != EINTR) break;
    for (pollfd& end : ends) {
      if (end.fd < 0 || end.revents == 0) continue;
      const ssize_t count = ::read(end.fd, buffer.data(), buffer.size());
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) {
        end.fd = -1;
        continue;
      }
      const std::string_view piece(buffer.data(), static_cast<std::size_t>(count));
      const Stream from = &end == ends.data() ? Stream::out : Stream::err;
      (from == Stream::out ? printed.out : printed.err) += piece;
      if (heard) heard(from, piece);
    }
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  printed.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return printed;
}

Job::~Job() {
  stop();
  if (thread_.joinable()) thread_.join();
}

bool Job::start(const Words& arguments, const std::filesystem::path& folder) {
  const std::lock_guard lock(mutex_);
  if (running_) return false;
  if (thread_.joinable()) thread_.join();
  running_ = true;
  ++version_;
  command_ = command_line(arguments);
  begun_.clear();
  progress_ = Json::object();
  lines_.clear();
  // Of its own, so that it lives as long as its child: the kernel ends that with the thread which made it.
  thread_ = std::thread([this, arguments, folder] {
    Printed printed;
    try {
      printed = run_itself(
          arguments, folder, [this](Stream from, std::string_view text) { hear(from, text); },
          [this](int process) {
            const std::lock_guard told(mutex_);
            process_ = process;
          });
    } catch (const std::exception& error) {
      printed.exit_code = kUnexpected;
      hear(Stream::err, std::string(error.what()) + "\n");
    }
    for (const Stream from : {Stream::out, Stream::err}) hear(from, "\n");  // what ended without one
    const std::lock_guard ended(mutex_);
    running_ = false;
    process_ = 0;
    progress_ = Json::object();
    exit_code_ = printed.exit_code;
    ++version_;
    changed_.notify_all();
  });
  changed_.notify_all();
  return true;
}

void Job::stop() {
  const std::lock_guard lock(mutex_);
  if (process_ > 0) ::kill(process_, SIGINT);
}

void Job::hear(Stream from, std::string_view text) {
  constexpr std::size_t kLinesKept = 2000;
  const std::lock_guard lock(mutex_);
  std::string& begun = begun_[from];
  begun += text;
  for (std::size_t end; (end = begun.find('\n')) != begun.npos; begun.erase(0, end + 1)) {
    const std::string line = begun.substr(0, end);
    if (Json said = Json::parse(line, nullptr, false); said.is_object() && said.contains("progress"))
      progress_ = std::move(said);
    else if (!line.empty())
      lines_.push_back(line);
  }
  if (lines_.size() > kLinesKept) lines_.erase(lines_.begin(), lines_.end() - kLinesKept);
  ++version_;
  changed_.notify_all();
}

Json Job::state(std::int64_t seen) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::seconds(1), [&] { return version_ > seen; });
  return {{"version", version_},
          {"command", command_},
          {"running", running_},
          {"progress", progress_.value("progress", "")},
          {"percent", progress_.value("percent", Json())},
          {"lines", lines_},
          {"exit_code", running_ ? Json() : Json(exit_code_)}};
}

}  // namespace tribotrack::apps
