#include "apps/text/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <map>
#include <set>
#include <system_error>
#include <thread>

#include "apps/program/errors.h"
#include "apps/program/streams.h"
#include "apps/text/input_file.h"
#include "vision/temporary_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void refuse(const fs::path& path, const std::string& why) {
  throw OutputError("{}: cannot be written: {}; give a path in a folder that exists and is yours to write to",
                    path.string(), why);
}

/// Refuses what must never be replaced by a file of ours.
void require_replaceable(const fs::path& path, Content content) {
  if (path.empty()) throw UsageError("the output file has no name");
  if (is_standard_output(path))
    throw InvalidInput("{}: this output cannot be written to standard output; give a file name",
                       path.string());
  if (content == Content::result && names_a_recording(path))
    throw InvalidInput(
        "{}: cannot be written: {} is the name of a recording or a picture, and the output is none; give "
        "another name",
        path.string(), path.extension().string());
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) refuse(path, "it is a folder");
  if (fs::exists(status) && !fs::is_regular_file(status))
    refuse(path, fs::is_fifo(status) ? "it is a fifo" : "it is a device, not a file");
  if (fs::exists(status) && ::access(path.c_str(), W_OK) != 0) refuse(path, "it is write-protected");
}

/// Device and inode of a file that is there, the whole path of one that is not yet: equal for the same file,
/// by whatever name or link.
std::string identity_of(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) return fmt::format("{}:{}", status.st_dev, status.st_ino);
  std::error_code error;
  return fs::weakly_canonical(fs::absolute(path, error), error).string();
}

fs::path meta_beside(const fs::path& path) {
  return path.string() + ".meta.json";
}

}  // namespace

bool is_standard_output(const fs::path& path) {
  const std::string name = path.string();
  return name == "-" || name == "/dev/stdout" || name == "/dev/fd/1" || name == "/proc/self/fd/1";
}

void require_writable(const std::vector<Output>& outputs, const std::vector<fs::path>& inputs) {
  std::map<std::string, fs::path> read;
  for (const fs::path& input : inputs) read.emplace(identity_of(input), input);
  std::set<std::string> written;
  std::set<fs::path> folders;
  for (const Output& output : outputs) {
    require_replaceable(output.path, output.content);
    const fs::path folder = output.path.has_parent_path() ? output.path.parent_path() : fs::path(".");
    if (!fs::is_directory(folder)) refuse(output.path, "its folder does not exist");
    std::vector<fs::path> files = {output.path};
    if (output.content == Content::result) files.push_back(meta_beside(output.path));
    for (const fs::path& file : files) {
      const std::string identity = identity_of(file);
      if (const auto input = read.find(identity); input != read.end())
        throw InvalidInput("{}: is an input of this command and would be overwritten{}; give another output",
                           input->second.string(),
                           file == input->second ? "" : " by the output " + file.string());
      if (!written.insert(identity).second)
        throw InvalidInput("{}: two outputs would be written to it; give each its own name", file.string());
    }
    if (!folders.insert(folder).second) continue;
    try {
      const vision::TemporaryFile probe(output.path);
    } catch (const vision::OutputError& error) {
      throw OutputError(error.what());
    }
  }
}

void write_file(const fs::path& path, std::string_view text, Content content) {
  require_replaceable(path, content);
  try {
    vision::TemporaryFile file(path);
    file.write(text);
    file.commit();
  } catch (const vision::OutputError& error) {
    throw OutputError(error.what());
  }
}

void create_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error || !fs::is_directory(path))
    throw InvalidInput("{}: the output folder cannot be created: {}; give one that can", path.string(),
                       error ? error.message() : "a file of that name is in the way");
  require_writable(path / "writable");
}

void remove_leftovers(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.') && name.find(vision::TemporaryFile::kMark) != name.npos)
      left.push_back(entry.path());
  }
  for (const fs::path& path : left) fs::remove_all(path, ignored);
}

namespace {

/// Waits for a signal's number, and ends the process as that signal would after clearing up.
void clean_up_when_told(int descriptor) {
  unsigned char number = 0;
  ssize_t count = 0;
  do count = ::read(descriptor, &number, 1);
  while (count < 0 && errno == EINTR);
  if (count != 1) return;
  vision::remove_partial_files();
  complain("stopped: nothing half-written is left; `run` and `watch` go on from finished recordings");
  ::_exit(128 + number);
}

}  // namespace

void clean_up_on_signals() {
  // Threads that libraries started before main() cannot be kept from taking a signal, so that blocking it
  // here is not enough: whichever thread takes it passes its number on, and the one below does what no signal
  // handler may.
  static int way[2];
  if (::pipe2(way, O_CLOEXEC) != 0) return;
  struct sigaction action {};
  action.sa_handler = [](int number) {
    const auto told = static_cast<unsigned char>(number);
    [[maybe_unused]] const ssize_t written = ::write(way[1], &told, 1);
  };
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) ::sigaction(number, &action, nullptr);
  // Past the limit of a file's size writing fails like on a full disk, and is answered as such.
  ::signal(SIGXFSZ, SIG_IGN);
  try {
    std::thread([] { clean_up_when_told(way[0]); }).detach();
  } catch (const std::system_error&) {
    // No thread is to be had: signals end the process at once, and remove_leftovers() clears up after it.
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) ::signal(number, SIG_DFL);
  }
}

}  // namespace tribotrack::apps
