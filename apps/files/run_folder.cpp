#include "apps/files/run_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "apps/program/errors.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

std::string this_process(const fs::path& campaign) {
  utsname host{};
  ::uname(&host);
  return fmt::format("process {} on {} (campaign {})", ::getpid(), host.nodename, campaign.string());
}

/// What the holder wrote into its lock.
std::string holder_in(const fs::path& file) {
  std::ifstream stream(file);
  std::string holder;
  std::getline(stream, holder);
  return holder.empty() ? "another process" : holder;
}

/// Is the open file still the one of that name? Whoever ends removes its lock file.
bool is_current(int descriptor, const fs::path& file) {
  struct stat open {
  }, named{};
  return ::fstat(descriptor, &open) == 0 && ::stat(file.c_str(), &named) == 0 &&
         open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

}  // namespace

std::vector<std::string> RunFolder::runs_besides(const std::vector<std::string>& names) const {
  std::vector<std::string> others;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(tracks(), ignored)) {
    const fs::path& path = entry.path();
    if (path.extension() != ".csv" || path.filename().string().starts_with('.')) continue;
    if (std::find(names.begin(), names.end(), path.stem().string()) == names.end())
      others.push_back(path.stem().string());
  }
  std::sort(others.begin(), others.end());
  return others;
}

std::vector<fs::path> RunFolder::files_of_report() const {
  std::vector<fs::path> files = {fit(), fit().string() + ".meta.json", log()};
  std::error_code ignored;
  for (const fs::path& folder : {tracks(), measurements()})
    for (const auto& entry : fs::directory_iterator(folder, ignored)) files.push_back(entry.path());
  return files;
}

RunFolderLock::RunFolderLock(const RunFolder& folder, const fs::path& campaign) : file_(folder.lock()) {
  while (true) {
    for (const fs::path& made : create_folder(folder.root)) made_.push_back(made);
    descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0) {
      if (errno == ENOENT) continue;  // its folder was removed by a run that came to nothing
      throw InvalidInput(fmt::format("{}: cannot be written: {}; give a folder that is yours to write to",
                                     file_.string(), std::strerror(errno)));
    }
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      ::close(descriptor_);
      throw InvalidInput(fmt::format(
          "{}: another run is writing there: {}; wait until it has finished, or give another folder",
          folder.root.string(), holder_in(file_)));
    }
    // A file system without locks: better without one than not at all.
    if (is_current(descriptor_, file_)) break;
    ::close(descriptor_);
  }
  for (const fs::path& folder_of_files : {folder.tracks(), folder.measurements()})
    for (const fs::path& made : create_folder(folder_of_files)) made_.push_back(made);
  const std::string holder = this_process(campaign) + "\n";
  if (::ftruncate(descriptor_, 0) != 0 ||
      ::write(descriptor_, holder.data(), holder.size()) != static_cast<::ssize_t>(holder.size())) {
    const std::string reason = std::strerror(errno);
    ::close(descriptor_);
    throw InvalidInput(fmt::format("{}: cannot be written: {}", file_.string(), reason));
  }
}

RunFolderLock::~RunFolderLock() {
  std::error_code ignored;
  fs::remove(file_, ignored);
  for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) fs::remove(*folder, ignored);
  ::close(descriptor_);
}

std::optional<std::string> writer_of(const RunFolder& folder) {
  const int descriptor = ::open(folder.lock().c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return std::nullopt;
  const bool held = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(descriptor);
  if (!held) return std::nullopt;
  return holder_in(folder.lock());
}

}  // namespace tribotrack::apps
