// Whole commands, each a process of its own.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <system_error>

#include "apps/bench/timing.h"
#include "apps/bench/vision.h"
#include "apps/bench/vision_scene.h"
#include "vision/frame_sink.h"

namespace tribotrack::bench {

namespace fs = std::filesystem;

namespace {

constexpr double kNoise = 2;  ///< grey levels
constexpr int kPoses = 50;    ///< a picture of 1280 x 800 takes 4 MB in memory

class TemporaryFolder {
 public:
  TemporaryFolder() : path_((fs::temp_directory_path() / "tribotrack-bench-XXXXXX").string()) {
    if (!::mkdtemp(path_.data()))
      throw vision::InputError("no folder can be made in " + fs::temp_directory_path().string());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  fs::path file(const std::string& name) const { return fs::path(path_) / name; }

 private:
  std::string path_;
};

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// Runs program and arguments to their end, what they print dropped; CPU time, s, user and system.
double cpu_time_of(std::vector<std::string> command) {
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (std::string& word : command) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t silent{};
  posix_spawn_file_actions_init(&silent);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&silent, stream, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int error = ::posix_spawn(&child, arguments[0], &silent, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&silent);
  if (error != 0)
    throw std::runtime_error(command[0] + ": cannot be started: " + std::generic_category().message(error));
  int status = 0;
  rusage used{};
  while (::wait4(child, &status, 0, &used) < 0)
    if (errno != EINTR) throw std::runtime_error(command[0] + ": its end cannot be waited for");
  constexpr int kDone = 0, kQualityGate = 4;  // a lost part is told by its row
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (code != kDone && code != kQualityGate)
    throw std::runtime_error(fmt::format("`{}` ended with exit code {}", fmt::join(command, " "), code));
  return seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
}

void record(const BenchScene& scene, int frames, const std::vector<fs::path>& files) {
  const std::vector<vision::Picture> exact = scene.render(frames);
  vision::SinkOptions options;
  options.width = scene.scene().width;
  options.height = scene.scene().height;
  std::vector<std::unique_ptr<vision::FrameSink>> sinks;
  for (const fs::path& file : files) sinks.push_back(vision::create_sink(file, options));
  for (int k = 0; k < frames; ++k) {
    const vision::Picture frame =
        recorded(exact[static_cast<std::size_t>(k) % exact.size()], kNoise, static_cast<std::uint64_t>(k));
    for (const auto& sink : sinks) sink->write(frame);
  }
  for (const auto& sink : sinks) sink->close();
}

/// Of a table with the columns x_px, y_px and a row for each frame; empty cells where the part is lost.
PositionErrors errors_in(const fs::path& table, const BenchScene& scene) {
  std::ifstream stream(table);
  const auto cells_of_next_line = [&stream] {
    std::vector<std::string> cells;
    std::string line;
    std::getline(stream, line);
    std::istringstream text(line);
    for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
    return cells;
  };
  const auto names = cells_of_next_line();
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  };
  const std::size_t x = column("x_px"), y = column("y_px");
  PositionErrors errors(scene);
  for (int frame = 0; stream.peek() != EOF; ++frame) {
    const auto cells = cells_of_next_line();
    std::optional<vision::Point> position;
    if (std::max(x, y) < cells.size() && !cells[x].empty())
      position = {std::strtod(cells[x].c_str(), nullptr), std::strtod(cells[y].c_str(), nullptr)};
    if (frame > 0) errors.see(frame, position);
  }
  return errors;
}

std::string text_of(const vision::Circle& circle) {
  return fmt::format("{:.6f},{:.6f},{:g}", circle.x, circle.y, circle.radius);
}

}  // namespace

WholeCommandOptions quick_whole_command_options() {
  WholeCommandOptions options;
  options.width = 240;
  options.height = 120;
  options.radius = 20;
  options.frames = 24;
  options.repetitions = 1;
  return options;
}

std::vector<ComparedRow> bench_whole_commands(const WholeCommandOptions& options) {
  std::vector<ComparedRow> rows;
  for (const double texture : {0.0, 10.0}) {
    const BenchScene scene(options.radius, texture, options.width, options.height, kPoses);
    const double bound = scene.bound(kNoise);
    const TemporaryFolder folder;
    const std::vector<fs::path> files{folder.file("recording.cine"), folder.file("recording.mp4")};
    record(scene, options.frames, files);
    for (const fs::path& file : files) {
      const std::string program = options.program.string(), part = text_of(scene.part(0)),
                        marker = text_of(scene.marker(0));
      const fs::path tables[] = {folder.file("ours.csv"), folder.file("peer.csv")};
      const std::vector<std::string> commands[] = {
          {program, "track", file.string(), "--marker", marker, "--fps", fmt::format("{:g}", kFrameRate),
           "--fps-reason", "rendered", "--threads", "1", "-o", tables[0].string()},
          {program, "bench-peer", file.string(), "--part", part, "--marker", marker, "-o",
           tables[1].string()}};
      std::vector<double> times[2];
      for (int turn = 0; turn < options.repetitions; ++turn)
        for (std::size_t k = 0; k < 2; ++k) times[k].push_back(cpu_time_of(commands[k]) / options.frames);
      for (std::size_t k = 0; k < 2; ++k) {
        const PositionErrors errors = errors_in(tables[k], scene);
        ComparedRow row;
        row.group = "whole commands";
        row.scene = fmt::format("{}, R = {:g} px, texture {:g}, noise {:g}, {} frames of {} x {}",
                                file.extension() == ".cine" ? "cine" : "H.264", options.radius, texture,
                                kNoise, options.frames, options.width, options.height);
        row.method = k == 0 ? "tribotrack track" : "windowed cv::matchTemplate";
        row.whose = k == 0 ? Whose::ours : Whose::peer;
        row.arrived = errors.count() > 3;
        row.error = errors.rms() / bound;
        row.time = median(times[k]);
        row.details = details_of(errors, bound);
        rows.push_back(row);
      }
    }
  }
  return rows;
}

}  // namespace tribotrack::bench
