// This program as a child of its own: what a page starts is the command line that it shows.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "apps/text/json.h"

namespace tribotrack::apps {

using Words = std::vector<std::string>;

/// "tribotrack track 'my slide.mp4'", as a shell takes it.
std::string command_line(const Words& arguments);

/// What a command printed, and how it ended.
struct Printed {
  int exit_code = 0;
  std::string out, err;
};

enum class Stream { out, err };

/// Runs this program in a folder; `heard` is told of its streams as they come, with lines of progress
/// (ProgressStyle::json). It ends with this process, however that ends. `started` is told its process.
Printed run_itself(const Words& arguments, const std::filesystem::path& folder,
                   const std::function<void(Stream, std::string_view)>& heard = {},
                   const std::function<void(int process)>& started = {});

/// The one command at work, or the last one.
class Job {
 public:
  ~Job();
  /// False while another is at work.
  bool start(const Words& arguments, const std::filesystem::path& folder);
  void stop();
  /// {version, command, running, progress, percent, lines, exit_code} once its version is beyond `seen`, or
  /// after a second; `lines` are those of both streams.
  Json state(std::int64_t seen);

 private:
  void hear(Stream from, std::string_view text);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::thread thread_;
  std::int64_t version_ = 0;
  int process_ = 0;
  bool running_ = false;
  std::string command_;
  std::map<Stream, std::string> begun_;  ///< lines whose ends are to come
  Json progress_ = Json::object();       ///< the last line of progress
  Words lines_;
  int exit_code_ = 0;
};

}  // namespace tribotrack::apps
