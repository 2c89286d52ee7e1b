#include "apps/bench/vision.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/LU>
#include <cerrno>
#include <memory>
#include <optional>
#include <system_error>

#include "apps/bench/timing.h"
#include "apps/bench/vision_peers.h"
#include "apps/bench/vision_scene.h"
#include "vision/frame_sink.h"
#include "vision/tracker.h"

namespace tribotrack::bench {

using namespace vision;

namespace fs = std::filesystem;

namespace {

/// What one method found in each frame, empty where it lost the part.
struct Finding {
  std::string method;
  Whose whose = Whose::peer;
  std::vector<std::optional<Point>> positions = {};
  std::vector<Eigen::Matrix2d> covariances = {};  ///< of ours, px^2
  double time = 0;                                ///< s a frame
  bool layered = false;
};

Finding track_as_users_do(FrameSource& source, const BenchScene& scene) {
  TrackOptions options;
  options.target.kind = Target::Kind::disc;
  options.target.disc = scene.part(0);
  options.marker.kind = MarkerChoice::Kind::circle;
  options.marker.circle = scene.marker(0);
  Finding finding{"tribotrack track", Whose::ours};
  const double begin = thread_seconds();
  const TrackResult result = track(source, options);
  finding.time = (thread_seconds() - begin) / static_cast<double>(source.info().frame_count);
  finding.layered = result.summary.layered;
  for (const TrackPoint& p : result.track.points) {
    finding.positions.push_back(p.status == TrackStatus::ok ? std::optional<Point>({p.x, p.y})
                                                            : std::nullopt);
    Eigen::Matrix2d covariance;
    const double mixed = p.rho_xy * p.sigma_x * p.sigma_y;
    covariance << p.sigma_x * p.sigma_x, mixed, mixed, p.sigma_y * p.sigma_y;
    finding.covariances.push_back(covariance);
  }
  return finding;
}

template <class Follow>
Finding follow_as_others_do(const char* method, Follow follow, FrameSource& source, const BenchScene& scene) {
  Finding finding{method};
  const double begin = thread_seconds();
  const std::vector<Point> positions = follow(source, {scene.part(0), scene.marker(0)});
  finding.time = (thread_seconds() - begin) / static_cast<double>(positions.size());
  finding.positions.assign(positions.begin(), positions.end());
  return finding;
}

ComparedRow judge(const Finding& finding, const BenchScene& scene, double noise, double bound) {
  ComparedRow row;
  row.group = scene.textured() ? "brushed platform" : "plain platform";
  row.scene = fmt::format("R = {:g} px, texture {:g}, noise {:g}", scene.part(0).radius,
                          scene.scene().platform.texture_rms, noise);
  row.method = finding.method;
  row.whose = finding.whose;
  row.time = finding.time;
  PositionErrors errors(scene);
  for (std::size_t k = 1; k < finding.positions.size(); ++k)  // the first is the template's own frame
    errors.see(static_cast<int>(k), finding.positions[k]);
  row.error = errors.rms() / bound;
  row.arrived = errors.count() > 3;
  if (finding.whose != Whose::ours) {
    row.details = details_of(errors, bound);
    return row;
  }
  double square = 0;
  for (const auto& [frame, error] : errors.centred())
    square += error.dot(finding.covariances[static_cast<std::size_t>(frame)].inverse() * error);
  row.details = details_of(errors, bound, std::sqrt(square / (2 * static_cast<double>(errors.count()) - 2)),
                           finding.layered);
  return row;
}

constexpr double kCommandNoise = 2;  ///< grey levels
constexpr int kCommandPoses = 50;    ///< a picture of 1280 x 800 takes 4 MB in memory

class TemporaryFolder {
 public:
  TemporaryFolder() : path_((fs::temp_directory_path() / "tribotrack-bench-XXXXXX").string()) {
    if (!::mkdtemp(path_.data()))
      throw InputError("no folder can be made in " + fs::temp_directory_path().string());
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
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  constexpr int kQualityGate = 4;  // a lost part: the row counts it
  if (code != 0 && code != kQualityGate)
    throw std::runtime_error(fmt::format("`{}` ended with exit code {}", fmt::join(command, " "), code));
  return seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
}

void record(const BenchScene& scene, int frames, const std::vector<fs::path>& files) {
  const std::vector<Picture> exact = scene.render(frames);
  SinkOptions options;
  options.width = scene.scene().width;
  options.height = scene.scene().height;
  std::vector<std::unique_ptr<FrameSink>> sinks;
  for (const fs::path& file : files) sinks.push_back(create_sink(file, options));
  for (int k = 0; k < frames; ++k) {
    const Picture frame = recorded(exact[static_cast<std::size_t>(k) % exact.size()], kCommandNoise,
                                   static_cast<std::uint64_t>(k));
    for (const auto& sink : sinks) sink->write(frame);
  }
  for (const auto& sink : sinks) sink->close();
}

}  // namespace

VisionBenchOptions quick_vision_options() {
  VisionBenchOptions options;
  options.radii = {10};
  options.textures = {0, 10};
  options.noises = {3};
  options.frames = 250;
  return options;
}

Comparison bench_vision(const VisionBenchOptions& options) {
  Comparison comparison{
      "vision",
      "Error of a position against run time",
      "rms error over the limit",
      "x limit",
      "CPU time of a frame",
      "truth of analytically rendered pictures; the limit is the Cramer-Rao bound with everything "
      "but the position known, the 1/12 of rounding included; the time of a whole command is ours from start "
      "to end of its process, the peer's without the start of one"};
  const int total = static_cast<int>(options.radii.size() * options.textures.size() * options.noises.size());
  int done = 0;
  for (const double radius : options.radii)
    for (const double texture : options.textures) {
      const BenchScene scene(radius, texture);
      const std::vector<Picture> exact = scene.render(options.frames);
      for (const double noise : options.noises) {
        std::vector<Picture> frames;
        for (int k = 0; k < options.frames; ++k)
          frames.push_back(recorded(exact[static_cast<std::size_t>(k) % exact.size()], noise,
                                    static_cast<std::uint64_t>(k)));
        MemorySource source(std::move(frames), kFrameRate);
        const double bound = scene.bound(noise);
        for (const Finding& finding :
             {track_as_users_do(source, scene),
              follow_as_others_do("windowed cv::matchTemplate", follow_by_matching, source, scene),
              follow_as_others_do("circle fit", follow_by_circle_fit, source, scene)})
          comparison.rows.push_back(judge(finding, scene, noise, bound));
        if (options.progress) options.progress(++done, total);
      }
    }
  return comparison;
}

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
    const BenchScene scene(options.radius, texture, options.width, options.height, kCommandPoses);
    const double bound = scene.bound(kCommandNoise);
    const TemporaryFolder folder;
    const std::vector<fs::path> files{folder.file("recording.cine"), folder.file("recording.mp4")};
    record(scene, options.frames, files);
    const Circle marker = scene.marker(0);
    for (const fs::path& file : files) {
      const std::vector<std::string> command{
          options.program.string(),
          "track",
          file.string(),
          "--marker",
          fmt::format("{:.6f},{:.6f},{:g}", marker.x, marker.y, marker.radius),
          "--fps",
          fmt::format("{:g}", kFrameRate),
          "--fps-reason",
          "rendered",
          "--threads",
          "1",
          "-o",
          folder.file("track.csv").string()};
      Finding ours, peer;
      std::vector<double> times[2];
      for (int turn = 0; turn < options.repetitions; ++turn) {
        times[0].push_back(cpu_time_of(command) / options.frames);
        const auto source = open_source(file, SourceOptions{kFrameRate});
        peer = follow_as_others_do("windowed cv::matchTemplate", follow_by_matching, *source, scene);
        times[1].push_back(peer.time);
        if (turn == 0) ours = track_as_users_do(*source, scene);
      }
      ours.time = median(times[0]);
      peer.time = median(times[1]);
      for (const Finding* finding : {&ours, &peer}) {
        rows.push_back(judge(*finding, scene, kCommandNoise, bound));
        rows.back().group = "whole commands";
        rows.back().scene += fmt::format(", {} frames of {} x {}, {}", options.frames, options.width,
                                         options.height, file.extension() == ".cine" ? "cine" : "H.264");
      }
    }
  }
  return rows;
}

}  // namespace tribotrack::bench
