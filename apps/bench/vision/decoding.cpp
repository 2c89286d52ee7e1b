#include "apps/bench/vision/decoding.h"

#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>

#include "apps/bench/timing/paired_timing.h"
#include "apps/bench/vision/recording.h"
#include "vision/frame_sink.h"
#include "vision/frame_source.h"
#include "vision/scene.h"
#include "vision/tracker.h"

namespace tribotrack::bench {

using namespace vision;

namespace {

namespace fs = std::filesystem;
using std::numbers::pi;

constexpr int kPoses = 60;
constexpr double kNoise = 2, kMarkerRadius = 12;

struct Coding {
  const char* name;
  const char* file;
};
constexpr Coding kCodings[] = {{"cine", "a.cine"}, {"ffv1", "a.mkv"}, {"mjpeg", "a.avi"}, {"h264", "a.mp4"}};

/// A folder of our own, gone at the end.
struct TemporaryFolder {
  fs::path path;
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "tribotrack-bench-XXXXXX").string();
    if (!::mkdtemp(name.data()))
      throw InputError("no folder can be made in " + fs::temp_directory_path().string());
    path = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

struct Path {
  Scene scene;
  bool brushed = false;
  Path(const VisionDecodingOptions& options, bool with_texture) : brushed(with_texture) {
    scene.width = options.width;
    scene.height = options.height;
    scene.disc.radius_px = options.radius;
    scene.disc.edge_blur_px = 0.8;
    scene.disc.scratches = 0;
    scene.disc.highlight = 0;
    scene.platform.level = 80;
    scene.platform.texture_rms = brushed ? 10 : 0;
    scene.marker = MarkerAppearance{marker(0), kMarkerRadius};
  }
  Point marker(int frame) const {
    const ScenePose p = pose(frame);
    return {scene.width / 2.0 - scene.disc.radius_px - 50 + p.platform.x, scene.height / 2.0 + p.platform.y};
  }
  ScenePose pose(int frame) const {
    const double turn = 2 * pi * frame / kPoses;
    ScenePose p;
    p.disc = {scene.width / 2.0 + 14 * std::cos(turn), scene.height / 2.0 - 14 * std::sin(turn)};
    if (brushed) p.platform = {5.6 * std::sin(5 * turn), 5.6 * std::cos(5 * turn) - 5.6};
    return p;
  }
};

void write(const Path& path, const VisionDecodingOptions& options, const fs::path& folder) {
  const SceneRenderer renderer(path.scene);
  std::vector<Picture> exact;
  for (int k = 0; k < std::min(kPoses, options.frames); ++k)
    exact.push_back(renderer.render_exact(0, 0, [p = path.pose(k)](double) { return p; }));
  SinkOptions sink;
  sink.width = options.width;
  sink.height = options.height;
  std::vector<std::unique_ptr<FrameSink>> sinks;
  for (const Coding& coding : kCodings) sinks.push_back(create_sink(folder / coding.file, sink));
  for (int k = 0; k < options.frames; ++k) {
    const Picture frame =
        recorded(exact[static_cast<std::size_t>(k % kPoses)], kNoise, static_cast<std::uint64_t>(k));
    for (auto& one : sinks) one->write(frame);
  }
  for (auto& one : sinks) one->close();
}

/// The rate is given: a container states a playback rate only.
std::unique_ptr<FrameSource> open(const fs::path& file) {
  return open_source(file, SourceOptions{kFrameRate});
}

void decode_all(const fs::path& file) {
  const auto source = open(file);
  Picture picture;
  const Rect window{source->info().width / 2, source->info().height / 2, 16, 16};
  for (std::int64_t k = 0; k < source->info().frame_count; ++k) source->read(k, window, picture);
}

TrackResult track_all(const fs::path& file, const Path& path) {
  TrackOptions options;
  options.target.kind = Target::Kind::disc;
  const Point start = path.pose(0).disc;
  options.target.disc = {start.x, start.y, path.scene.disc.radius_px};
  options.marker.kind = MarkerChoice::Kind::circle;
  const Point marker = path.marker(0);
  options.marker.circle = {marker.x, marker.y, kMarkerRadius};
  if (!path.brushed) options.layers = Layers::off;
  const auto source = open(file);
  return track(*source, options);
}

void judge(const Track& track, const Path& path, VisionDecodingRow& row) {
  Point mean;
  double square = 0, count = 0;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const TrackPoint& p = track.points[k];
    row.lost += p.status != TrackStatus::ok;
    if (p.status != TrackStatus::ok) continue;
    const Point truth = path.pose(static_cast<int>(k)).disc;
    const Point e{p.x - truth.x, p.y - truth.y};
    mean.x += e.x;
    mean.y += e.y;
    square += e.x * e.x + e.y * e.y;
    ++count;
  }
  if (count < 4) return;
  const double offset = (mean.x * mean.x + mean.y * mean.y) / count;
  row.rms = std::sqrt(std::max(0.0, square - offset) / (2 * (count - 1)));
}

}  // namespace

VisionDecodingOptions quick_decoding_options() {
  VisionDecodingOptions options;
  options.width = 160;
  options.height = 96;
  options.radius = 12;
  options.frames = 24;
  options.repetitions = 1;
  return options;
}

std::vector<VisionDecodingRow> bench_decoding(const VisionDecodingOptions& options) {
  std::vector<VisionDecodingRow> rows;
  for (const bool brushed : {false, true}) {
    const Path path(options, brushed);
    const TemporaryFolder folder;
    write(path, options, folder.path);
    for (const Coding& coding : kCodings) {
      const fs::path file = folder.path / coding.file;
      VisionDecodingRow row;
      row.coding = coding.name;
      row.brushed = brushed;
      row.radius = options.radius;
      row.frames = options.frames;
      std::vector<double> decoding, tracking;
      for (int k = 0; k < options.repetitions; ++k) {
        const double begin = thread_seconds();
        decode_all(file);
        const double between = thread_seconds();
        const TrackResult result = track_all(file, path);
        decoding.push_back((between - begin) / options.frames);
        tracking.push_back((thread_seconds() - between) / options.frames);
        if (k > 0) continue;
        row.layered = result.summary.layered;
        judge(result.track, path, row);
      }
      row.decoding = median(decoding);
      row.tracking = median(tracking);
      rows.push_back(row);
      if (options.progress)
        options.progress(static_cast<int>(rows.size()), static_cast<int>(2 * std::size(kCodings)));
    }
  }
  return rows;
}

}  // namespace tribotrack::bench
