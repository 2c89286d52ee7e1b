#include "apps/bench/vision/limit.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "apps/bench/timing/paired_timing.h"
#include "apps/bench/vision/recording.h"
#include "vision/cramer_rao_bound.h"
#include "vision/scene.h"
#include "vision/tracker.h"

namespace tribotrack::bench {

using namespace vision;

namespace {

using std::numbers::pi;

constexpr int kPoses = 125;
constexpr double kMarker = 26, kMarkerRadius = 12;  ///< px

struct Path {
  Scene scene;
  ScenePose pose(int frame) const {
    const double turn = 2 * pi * frame / kPoses;
    ScenePose p;
    p.disc = {scene.width / 2.0 + 29.7 + 3.7 * std::cos(3 * turn),
              scene.height / 2.0 - 0.6 + 3.7 * std::sin(3 * turn)};
    if (scene.platform.texture_rms > 0) p.platform = {5.6 * std::cos(5 * turn), -5.6 * std::sin(5 * turn)};
    return p;
  }
  std::function<ScenePose(double)> at(int frame) const {
    return [p = pose(frame)](double) { return p; };
  }
};

Path path_of(double radius, double texture) {
  Path path;
  Scene& s = path.scene;
  s.height = 2 * (static_cast<int>(std::ceil(radius)) + 22) + 1;
  s.width = s.height + 60;
  s.disc.radius_px = radius;
  s.disc.edge_blur_px = 0.7;
  s.disc.scratches = 0;
  s.disc.highlight = 0;
  s.platform.texture_rms = texture;
  s.marker = MarkerAppearance{{kMarker, kMarker}, kMarkerRadius};
  return path;
}

double bound_of(const Path& path, double noise) {
  Scene scene = path.scene;
  scene.read_noise = noise;
  const SceneRenderer renderer(scene);
  constexpr int kSamples = 8;
  double variance = 0;
  for (int k = 0; k < kSamples; ++k)
    variance += position_bound(renderer, 0, 0, path.at(k * kPoses / kSamples)).trace() / (2 * kSamples);
  return std::sqrt(variance);
}

void judge(const Track& track, const Path& path, VisionLimitRow& row) {
  std::vector<Eigen::Vector2d> errors;
  std::vector<Eigen::Matrix2d> weights;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (std::size_t k = 1; k < track.points.size(); ++k) {  // the first is the template's own frame
    const TrackPoint& p = track.points[k];
    row.lost += p.status != TrackStatus::ok;
    if (p.status != TrackStatus::ok) continue;
    const Point truth = path.pose(static_cast<int>(k) % kPoses).disc;
    errors.emplace_back(p.x - truth.x, p.y - truth.y);
    mean += errors.back();
    Eigen::Matrix2d covariance;
    const double mixed = p.rho_xy * p.sigma_x * p.sigma_y;
    covariance << p.sigma_x * p.sigma_x, mixed, mixed, p.sigma_y * p.sigma_y;
    weights.push_back(covariance.inverse());
  }
  row.components = static_cast<int>(2 * errors.size());
  if (errors.size() < 4) return;
  mean /= static_cast<double>(errors.size());
  double square = 0, standardised = 0;
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const Eigen::Vector2d e = errors[k] - mean;
    square += e.squaredNorm();
    standardised += e.dot(weights[k] * e);
  }
  const double n = 2 * static_cast<double>(errors.size() - 1);
  row.rms = std::sqrt(square / n);
  row.standardised = std::sqrt(standardised / n);
}

VisionLimitRow measure(const Path& path, const std::vector<Picture>& exact, double noise, int frames) {
  std::vector<Picture> recording;
  for (int k = 0; k < frames; ++k)
    recording.push_back(
        recorded(exact[static_cast<std::size_t>(k % kPoses)], noise, static_cast<std::uint64_t>(k)));
  MemorySource source(std::move(recording), kFrameRate);
  TrackOptions options;
  options.target.kind = Target::Kind::disc;
  const ScenePose first = path.pose(0);
  options.target.disc = {first.disc.x, first.disc.y, path.scene.disc.radius_px};
  options.marker.kind = MarkerChoice::Kind::circle;
  options.marker.circle = {kMarker + first.platform.x, kMarker + first.platform.y, kMarkerRadius};
  VisionLimitRow row;
  row.radius = path.scene.disc.radius_px;
  row.texture = path.scene.platform.texture_rms;
  row.noise = noise;
  row.bound = bound_of(path, noise);
  const double begin = thread_seconds();
  const TrackResult result = track(source, options);
  row.time = (thread_seconds() - begin) / frames;
  row.layered = result.summary.layered;
  row.audit = result.summary.audit;
  row.noise_found = result.summary.noise_levels;
  judge(result.track, path, row);
  return row;
}

}  // namespace

VisionLimitOptions quick_limit_options() {
  VisionLimitOptions options;
  options.radii = {10};
  options.textures = {0, 10};
  options.noises = {3};
  options.frames = 250;
  return options;
}

std::vector<VisionLimitRow> bench_limit(const VisionLimitOptions& options) {
  const int total = static_cast<int>(options.radii.size() * options.textures.size() * options.noises.size());
  std::vector<VisionLimitRow> rows;
  for (const double radius : options.radii)
    for (const double texture : options.textures) {
      const Path path = path_of(radius, texture);
      const SceneRenderer renderer(path.scene);
      std::vector<Picture> exact;
      for (int k = 0; k < std::min(kPoses, options.frames); ++k)
        exact.push_back(renderer.render_exact(0, 0, path.at(k)));
      for (const double noise : options.noises) {
        rows.push_back(measure(path, exact, noise, options.frames));
        if (options.progress) options.progress(static_cast<int>(rows.size()), total);
      }
    }
  return rows;
}

}  // namespace tribotrack::bench
