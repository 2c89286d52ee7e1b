#include "apps/bench/vision.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <numbers>
#include <optional>

#include "apps/bench/timing.h"
#include "apps/bench/vision_peers.h"
#include "apps/bench/vision_scene.h"
#include "vision/tracker.h"

namespace tribotrack::bench {

using namespace vision;

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
      "1",
      "CPU time of a frame",
      "truth of analytically rendered pictures; the limit is the Cramer-Rao bound with everything "
      "but the position known, the 1/12 of rounding included"};
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

}  // namespace tribotrack::bench
