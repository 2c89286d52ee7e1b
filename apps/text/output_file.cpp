#include "apps/text/output_file.h"

#include <fmt/format.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <mutex>
#include <set>
#include <thread>

#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

// A signal can come at any time, so what it has to remove is the one piece of state kept per process.
class TemporaryNames {
 public:
  static TemporaryNames& of_this_process() {
    static TemporaryNames names;
    return names;
  }
  fs::path add(const fs::path& path) {
    const std::lock_guard lock(mutex_);
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    // The extension stays last: video muxers choose the container by it.
    fs::path name = folder / fmt::format(".partial-{}-{}-{}", ::getpid(), ++count_, path.filename().string());
    names_.insert(name);
    return name;
  }
  void remove(const fs::path& name) {
    const std::lock_guard lock(mutex_);
    erase_derived(name);
    names_.erase(name);
  }
  void forget(const fs::path& name) {
    const std::lock_guard lock(mutex_);
    names_.erase(name);
  }
  void remove_all() {
    const std::lock_guard lock(mutex_);
    for (const fs::path& name : names_) erase_derived(name);
    names_.clear();
  }

 private:
  static void erase_derived(const fs::path& name) {
    std::error_code ignored;
    const std::string stem = name.filename().string();
    for (const auto& entry : fs::directory_iterator(name.parent_path(), ignored))
      if (entry.path().filename().string().find(stem) != std::string::npos)
        fs::remove_all(entry.path(), ignored);
  }

  std::mutex mutex_;
  std::set<fs::path> names_;
  int count_ = 0;
};

[[noreturn]] void refuse(const fs::path& path, const std::string& why) {
  throw InvalidInput(
      fmt::format("{}: cannot be written: {}; give a path in a folder that exists and is yours to write to",
                  path.string(), why));
}

}  // namespace

TemporaryFile::TemporaryFile(const fs::path& path)
    : path_(path), temporary_(TemporaryNames::of_this_process().add(path)) {}

TemporaryFile::~TemporaryFile() {
  TemporaryNames::of_this_process().remove(temporary_);
}

void TemporaryFile::commit() {
  std::error_code error;
  fs::rename(temporary_, path_, error);
  if (error) refuse(path_, error.message());
  TemporaryNames::of_this_process().forget(temporary_);
}

void write_file(const fs::path& path, std::string_view content) {
  if (fs::is_directory(path)) refuse(path, "it is a folder");
  TemporaryFile file(path);
  {
    std::ofstream stream(file.name(), std::ios::binary);
    if (!stream) refuse(path, std::strerror(errno));
    stream.write(content.data(), static_cast<std::streamsize>(content.size()));
    stream.flush();
    if (!stream) refuse(path, std::strerror(errno));
  }
  file.commit();
}

void require_writable(const fs::path& path) {
  if (path.empty()) throw UsageError("the output file has no name");
  if (fs::is_directory(path)) refuse(path, "it is a folder");
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(folder)) refuse(path, "its folder does not exist");
  TemporaryFile probe(path);
  std::ofstream stream(probe.name());
  if (!stream) refuse(path, std::strerror(errno));
}

void create_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error || !fs::is_directory(path))
    throw InvalidInput(fmt::format("{}: the output folder cannot be created: {}; give one that can",
                                   path.string(),
                                   error ? error.message() : "a file of that name is in the way"));
  require_writable(path / "writable");
}

void clean_up_on_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, number);
  // Blocked in this thread and all that it starts; the one below takes them, outside of any signal handler.
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([signals] {
    int number = 0;
    if (sigwait(&signals, &number) != 0) return;
    TemporaryNames::of_this_process().remove_all();
    ::_exit(128 + number);
  }).detach();
}

}  // namespace tribotrack::apps
