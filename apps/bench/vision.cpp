// Trackers over a grid of radii, textures of the platform and noises.
#include "apps/bench/comparison.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <sys/resource.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "apps/bench/timing.h"
#include "vision/cramer_rao_bound.h"
#include "vision/frame_sink.h"
#include "vision/scene.h"
#include "vision/synthesis/camera.h"
#include "vision/tracker.h"

namespace tribotrack::bench {

using namespace vision;

namespace {

/// A disc goes round beside a marker, over a platform that rests or over a textured one that moves.
class BenchScene {
 public:
  static constexpr double kMarker = 26, kMarkerRadius = 12;  ///< px
  static constexpr int kPoses = 125;                         ///< of one turn; they come again

  /// `texture`: of the platform, grey levels rms; without it rests. The picture is as small as it can be, or
  /// of the size given.
  BenchScene(double radius, double texture, int width = 0, int height = 0) {
    const int reach = static_cast<int>(std::ceil(radius)) + 22;
    scene_.width = std::max(width, 2 * reach + 61);
    scene_.height = std::max(height, 2 * reach + 1);
    scene_.disc.radius_px = radius;
    scene_.disc.edge_blur_px = 0.7;
    scene_.disc.scratches = 0;
    scene_.disc.highlight = 0;
    scene_.platform.texture_rms = texture;
    scene_.marker = MarkerAppearance{{kMarker, kMarker}, kMarkerRadius};
  }

  const Scene& scene() const { return scene_; }
  double texture() const { return scene_.platform.texture_rms; }
  ScenePose pose(int frame) const {
    const double turn = 2 * std::numbers::pi * (frame % kPoses) / kPoses;
    ScenePose p;
    p.disc = {scene_.width / 2.0 + 29.7 + 3.7 * std::cos(3 * turn),
              scene_.height / 2.0 - 0.6 + 3.7 * std::sin(3 * turn)};
    if (texture() > 0) p.platform = {5.6 * std::cos(5 * turn), -5.6 * std::sin(5 * turn)};
    return p;
  }
  std::function<ScenePose(double)> at(int frame) const {
    return [p = pose(frame)](double) { return p; };
  }
  Circle part(int frame) const {
    const ScenePose p = pose(frame);
    return {p.disc.x, p.disc.y, scene_.disc.radius_px};
  }
  Circle marker(int frame) const {
    const ScenePose p = pose(frame);
    return {kMarker + p.platform.x, kMarker + p.platform.y, kMarkerRadius};
  }
  /// The poses of the first `frames` frames, without noise.
  std::vector<Picture> render(int frames) const {
    const SceneRenderer renderer(scene_);
    std::vector<Picture> exact;
    for (int k = 0; k < std::min(kPoses, frames); ++k) exact.push_back(renderer.render_exact(0, 0, at(k)));
    return exact;
  }
  /// The Cramer-Rao bound under this noise, px, rms over the path and both coordinates.
  double bound(double noise) const {
    Scene noisy = scene_;
    noisy.read_noise = noise;
    const SceneRenderer renderer(noisy);
    constexpr int kSamples = 8;
    double variance = 0;
    for (int k = 0; k < kSamples; ++k)
      variance += position_bound(renderer, 0, 0, at(k * kPoses / kSamples)).trace() / (2 * kSamples);
    return std::sqrt(variance);
  }

 private:
  Scene scene_;
};

/// A picture as an 8-bit camera records it: white noise of `noise` grey levels, then rounding and clipping.
Picture recorded(const Picture& exact, double noise, int frame) {
  const CounterRandom random(20210, static_cast<std::uint64_t>(frame));
  Picture out = exact;
  std::uint64_t counter = 0;
  for (float& level : out.levels())
    level =
        std::clamp(std::round(level + static_cast<float>(noise) * random.gaussian(counter++)), 0.0F, 255.0F);
  return out;
}

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

/// cv::matchTemplate in a window about the last position, the template the target's square in the first
/// frame: the highest point of the correlation, between pixels by three points along each axis.
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

/// A circle through the points of steepest grey level along rays from the last position (Kasa's fit: linear
/// least squares), three times in each frame, the last two without edges that lie beside it.
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

/// Follows the part and the marker, told where they lie in the first frame.
template <class Method>
Finding follow_as_others_do(const char* name, FrameSource& source, const BenchScene& scene) {
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  Finding finding{name};
  const double begin = thread_seconds();
  Method part(source, scene.part(0)), marker(source, scene.marker(0));
  for (std::int64_t k = 0; k < source.info().frame_count; ++k) {
    finding.positions.push_back(part.locate(source, k));
    marker.locate(source, k);
  }
  finding.time = (thread_seconds() - begin) / static_cast<double>(source.info().frame_count);
  cv::setNumThreads(threads);
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
  row.group = scene.texture() > 0 ? "brushed platform" : "plain platform";
  row.scene =
      fmt::format("R = {:g} px, texture {:g}, noise {:g}", scene.part(0).radius, scene.texture(), noise);
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

/// CPU time of the processes that have ended, user and system, s.
double seconds_of_children() {
  rusage used{};
  ::getrusage(RUSAGE_CHILDREN, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

/// A recording on which `track` is timed as a whole command.
struct WholeCommands {
  int width, height;
  double radius;  ///< px
  int frames;
};

/// `tribotrack track` from the start of its process to its end, and a peer that decodes and matches, in turns
/// on one recording: medians of three.
void time_whole_commands(const std::filesystem::path& program, const WholeCommands& whole, double texture,
                         Comparison& comparison) {
  constexpr double kNoise = 2, kRate = 1000;
  const BenchScene scene(whole.radius, texture, whole.width, whole.height);
  std::string folder = (std::filesystem::temp_directory_path() / "tribotrack-bench-XXXXXX").string();
  if (!::mkdtemp(folder.data())) throw InputError(folder + " cannot be made; make room, or set TMPDIR");
  const std::string file = folder + "/recording.cine";
  const auto sink = create_sink(file, {.width = whole.width, .height = whole.height, .frame_rate_hz = kRate});
  const SceneRenderer renderer(scene.scene());
  for (int k = 0; k < whole.frames; ++k)
    sink->write(recorded(renderer.render_exact(0, 0, scene.at(k)), kNoise, k));
  sink->close();
  const Circle part = scene.part(0), marker = scene.marker(0);
  const std::string command = fmt::format(
      "'{}' track {} --disc {:.4f},{:.4f},{:g} --marker {:.4f},{:.4f},{:g} --threads 1 -q -o {}/track.csv "
      ">/dev/null 2>&1",
      program.string(), file, part.x, part.y, part.radius, marker.x, marker.y, marker.radius, folder);
  Finding ours, peer;
  std::vector<double> of_ours, of_peer;
  for (int turn = 0; turn < 3; ++turn) {
    const double before = seconds_of_children();
    if (std::system(command.c_str()) != 0) throw std::runtime_error(command + " failed");
    of_ours.push_back((seconds_of_children() - before) / whole.frames);
    const auto source = open_source(file);
    peer = follow_as_others_do<Matching>("windowed cv::matchTemplate", *source, scene);
    of_peer.push_back(peer.time);
    if (turn == 0) ours = track_as_users_do(*source, scene);
  }
  std::filesystem::remove_all(folder);
  ours.time = upper_median(of_ours);
  peer.time = upper_median(of_peer);
  for (const Finding& finding : {ours, peer}) {
    comparison.rows.push_back(judge(finding, scene, kNoise, scene.bound(kNoise)));
    comparison.rows.back().group = "whole command";
    comparison.rows.back().scene +=
        fmt::format(", {} frames of {} x {}", whole.frames, whole.width, whole.height);
  }
}

}  // namespace

Comparison bench_vision(const BenchOptions& options) {
  const bool quick = options.quick;
  using List = std::vector<double>;
  const List radii = quick ? List{10} : List{10, 30, 60, 150, 200};  // px
  const List textures = quick ? List{0, 10} : List{0, 5, 10, 20};    // grey levels rms
  const List noises = quick ? List{3} : List{1, 3, 8};               // grey levels, without that of rounding
  const int count = quick ? 250 : 1050;                              // frames of a recording
  // Of `track` as a whole command:
  const WholeCommands whole = quick ? WholeCommands{320, 200, 20, 24} : WholeCommands{1280, 800, 60, 405};
  Comparison comparison{"vision",
                        "Error of a position against run time",
                        "rms error over the limit",
                        "x limit",
                        "CPU time of a frame",
                        "truth of analytically rendered pictures; the limit is the Cramer-Rao bound with "
                        "everything but the position known, the 1/12 of rounding included; a whole command's "
                        "time is ours from start to end of its process, the peer's decodes and matches"};
  const int total = static_cast<int>(radii.size() * textures.size() * noises.size());
  int done = 0;
  for (const double radius : radii)
    for (const double texture : textures) {
      const BenchScene scene(radius, texture);
      const std::vector<Picture> exact = scene.render(count);
      for (const double noise : noises) {
        std::vector<Picture> frames;
        for (int k = 0; k < count; ++k)
          frames.push_back(recorded(exact[static_cast<std::size_t>(k) % exact.size()], noise, k));
        MemorySource source(std::move(frames), 1000);
        const double bound = scene.bound(noise);
        for (const Finding& finding :
             {track_as_users_do(source, scene),
              follow_as_others_do<Matching>("windowed cv::matchTemplate", source, scene),
              follow_as_others_do<CircleFit>("circle fit", source, scene)})
          comparison.rows.push_back(judge(finding, scene, noise, bound));
        if (options.progress) options.progress(++done, total);
      }
    }
  if (!options.program.empty())
    for (const double texture : {0.0, 10.0}) time_whole_commands(options.program, whole, texture, comparison);
  return comparison;
}

}  // namespace tribotrack::bench
