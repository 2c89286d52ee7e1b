#include "apps/bench/vision.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <memory>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "apps/bench/timing.h"
#include "apps/bench/vision_scene.h"
#include "vision/frame_sink.h"
#include "vision/tracker.h"

namespace tribotrack::bench {

using namespace vision;

namespace {

/// How far a search goes from the last position, px: several times what moves in these recordings.
constexpr int kSearch = 8;

/// A square about a target, as far as it lies in the frame.
Rect window_about(const Circle& target, int reach, const Rect& frame) {
  return common(frame, {static_cast<int>(std::lround(target.x)) - reach,
                        static_cast<int>(std::lround(target.y)) - reach, 2 * reach + 1, 2 * reach + 1});
}

/// The template's square reaches so far from the pixel nearest to the disc's centre, px.
int template_reach(const Circle& disc) {
  return static_cast<int>(std::ceil(disc.radius)) + 3;
}

cv::Mat matrix_of(const Picture& picture) {
  const cv::Mat view(picture.height(), picture.width(), CV_32F, const_cast<float*>(picture.levels().data()));
  cv::Mat out;
  view.convertTo(out, CV_8U);
  return out;
}

/// The highest point of the correlation, between pixels by three points along each axis.
class Matching {
 public:
  Matching(FrameSource& source, const Circle& target) : last_(target) {
    const Rect window = window_about(target, template_reach(target), source.bounds());
    source.read(0, window, picture_);
    template_ = matrix_of(picture_);
    offset_ = {target.x - window.x, target.y - window.y};
  }
  Point locate(FrameSource& source, std::int64_t index) {
    const Rect window = window_about(last_, template_reach(last_) + kSearch, source.bounds());
    source.read(index, window, picture_);
    cv::matchTemplate(matrix_of(picture_), template_, scores_, cv::TM_CCOEFF_NORMED);
    cv::Point best;
    cv::minMaxLoc(scores_, nullptr, nullptr, nullptr, &best);
    last_.x = window.x + best.x + offset_.x + between(best, 1, 0);
    last_.y = window.y + best.y + offset_.y + between(best, 0, 1);
    return {last_.x, last_.y};
  }

 private:
  double between(const cv::Point& best, int dx, int dy) const {
    if (best.x < dx || best.y < dy || best.x + dx >= scores_.cols || best.y + dy >= scores_.rows) return 0;
    const double before = scores_.at<float>(best.y - dy, best.x - dx),
                 middle = scores_.at<float>(best.y, best.x),
                 after = scores_.at<float>(best.y + dy, best.x + dx);
    const double curvature = before - 2 * middle + after;
    return curvature < 0 ? 0.5 * (before - after) / curvature : 0;
  }

  Circle last_;
  Picture picture_;
  cv::Mat template_, scores_;
  Point offset_;
};

/// Between pixel centres; the nearest pixel outside.
double level_at(const Picture& picture, double x, double y) {
  x = std::clamp(x, 0.0, picture.width() - 1.001);
  y = std::clamp(y, 0.0, picture.height() - 1.001);
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const double u = x - i, v = y - j;
  return (1 - v) * ((1 - u) * picture.at(i, j) + u * picture.at(i + 1, j)) +
         v * ((1 - u) * picture.at(i, j + 1) + u * picture.at(i + 1, j + 1));
}

class CircleFit {
 public:
  CircleFit(FrameSource&, const Circle& target) : last_(target) {}
  Point locate(FrameSource& source, std::int64_t index) {
    const int reach = static_cast<int>(std::ceil(last_.radius)) + kSearch;
    const Rect window = window_about(last_, reach, source.bounds());
    source.read(index, window, picture_);
    const Circle before = last_;
    for (int round = 0; round < 3; ++round) fit(window, round == 0 ? HUGE_VAL : kOff);
    if (std::hypot(last_.x - before.x, last_.y - before.y) > kSearch) last_ = before;  // it ran away
    return {last_.x, last_.y};
  }

 private:
  static constexpr double kOff = 1.5;  ///< px from the circle found before: an edge of something else

  /// Through the edges that lie no farther than `off` from the circle of the round before.
  void fit(const Rect& window, double off) {
    const Point centre{last_.x - window.x, last_.y - window.y};
    const auto rays = std::clamp(std::lround(4 * last_.radius), 32L, 512L);
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d side = Eigen::Vector3d::Zero();
    for (long k = 0; k < rays; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(rays);
      const double c = std::cos(angle), s = std::sin(angle), r = edge_along(centre, c, s);
      if (std::abs(r - last_.radius) > off) continue;
      const Eigen::Vector3d row(r * c, r * s, 1);
      normal += row * row.transpose();
      side += r * r * row;
    }
    if (normal(2, 2) < 8) return;  // points
    const Eigen::Vector3d found = normal.ldlt().solve(side);
    last_.x += found(0) / 2;
    last_.y += found(1) / 2;
  }
  /// Where the grey level is steepest, by a parabola through three differences.
  double edge_along(const Point& centre, double c, double s) const {
    constexpr double kStep = 0.5, kHalfWidth = 1, kFrom = 4;
    const auto steepness = [&](double r) {
      return std::abs(level_at(picture_, centre.x + (r + kHalfWidth) * c, centre.y + (r + kHalfWidth) * s) -
                      level_at(picture_, centre.x + (r - kHalfWidth) * c, centre.y + (r - kHalfWidth) * s));
    };
    double best = last_.radius, most = -1;
    for (double r = last_.radius - kFrom; r <= last_.radius + kFrom; r += kStep)
      if (const double here = steepness(r); here > most) {
        most = here;
        best = r;
      }
    const double before = steepness(best - kStep), after = steepness(best + kStep);
    const double curvature = before - 2 * most + after;
    return curvature < 0 ? best + 0.5 * kStep * (before - after) / curvature : best;
  }

  Circle last_;
  Picture picture_;
};

template <class Method>
std::vector<Point> follow(FrameSource& source, const std::vector<Circle>& targets) {
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  std::vector<Method> followed;
  for (const Circle& target : targets) followed.emplace_back(source, target);
  std::vector<Point> positions;
  for (std::int64_t k = 0; k < source.info().frame_count; ++k)
    for (std::size_t t = 0; t < followed.size(); ++t) {
      const Point found = followed[t].locate(source, k);
      if (t == 0) positions.push_back(found);
    }
  cv::setNumThreads(threads);
  return positions;
}

}  // namespace

std::vector<Point> follow_by_matching(FrameSource& source, const std::vector<Circle>& targets) {
  return follow<Matching>(source, targets);
}

std::vector<Point> follow_by_circle_fit(FrameSource& source, const std::vector<Circle>& targets) {
  return follow<CircleFit>(source, targets);
}

namespace fs = std::filesystem;

namespace {

/// What one method found in each frame, empty where it lost the part.
struct Finding {
  std::string method;
  bool ours = false;
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
  Finding finding{"tribotrack track", true};
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

/// The errors are those about their mean, per coordinate; 0 from fewer than four positions.
ComparedRow judge(const Finding& finding, const BenchScene& scene, double noise, double bound) {
  std::vector<std::pair<std::size_t, Eigen::Vector2d>> errors;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double lost = 0;
  for (std::size_t k = 1; k < finding.positions.size(); ++k) {  // the first is the template's own frame
    const Point truth = scene.pose(static_cast<int>(k)).disc;
    lost += !finding.positions[k];
    if (!finding.positions[k]) continue;
    errors.emplace_back(
        k, Eigen::Vector2d(finding.positions[k]->x - truth.x, finding.positions[k]->y - truth.y));
    mean += errors.back().second;
  }
  const auto count = static_cast<double>(errors.size());
  double square = 0, standardised = 0;
  for (auto& [frame, error] : errors) {
    error -= mean / count;
    square += error.squaredNorm();
    if (finding.ours) standardised += error.dot(finding.covariances[frame].inverse() * error);
  }
  ComparedRow row;
  row.group = scene.textured() ? "brushed platform" : "plain platform";
  row.scene = fmt::format("R = {:g} px, texture {:g}, noise {:g}", scene.part(0).radius,
                          scene.scene().platform.texture_rms, noise);
  row.method = finding.method;
  row.ours = finding.ours;
  row.time = finding.time;
  row.arrived = errors.size() > 3;
  const double rms = row.arrived ? std::sqrt(square / (2 * (count - 1))) : 0;
  row.error = rms / bound;
  row.details = {{"rms_px", rms}, {"bound_px", bound}, {"lost", lost}, {"components", 2 * count}};
  // What only our tracker tells.
  row.details.push_back({"standardised", finding.ours ? std::sqrt(standardised / (2 * count - 2)) : NAN});
  row.details.push_back({"layered", finding.ours ? finding.layered : NAN});
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
      ours.time = upper_median(times[0]);
      peer.time = upper_median(times[1]);
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
