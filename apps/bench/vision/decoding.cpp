#include "apps/bench/vision/decoding.h"

#include <filesystem>

#include "apps/bench/timing/paired_timing.h"
#include "apps/bench/vision/circling.h"
#include "vision/tracker.h"

namespace tribotrack::bench {

using namespace vision;

namespace {

namespace fs = std::filesystem;

struct Coding {
  const char* name;
  const char* file;
};
constexpr Coding kCodings[] = {{"cine", "a.cine"}, {"ffv1", "a.mkv"}, {"mjpeg", "a.avi"}, {"h264", "a.mp4"}};

void decode_all(const fs::path& file) {
  const auto source = open_recording(file);
  Picture picture;
  const Rect window{source->info().width / 2, source->info().height / 2, 16, 16};
  for (std::int64_t k = 0; k < source->info().frame_count; ++k) source->read(k, window, picture);
}

TrackResult track_all(const fs::path& file, const CirclingScene& scene) {
  TrackOptions options;
  options.target.kind = Target::Kind::disc;
  options.target.disc = scene.part(0);
  options.marker.kind = MarkerChoice::Kind::circle;
  options.marker.circle = scene.mark(0);
  if (!scene.brushed()) options.layers = Layers::off;
  const auto source = open_recording(file);
  return track(*source, options);
}

void judge(const Track& track, const CirclingScene& scene, VisionDecodingRow& row) {
  PositionErrors errors(scene);
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const TrackPoint& p = track.points[k];
    if (p.status == TrackStatus::ok)
      errors.see(static_cast<int>(k), {p.x, p.y});
    else
      ++row.lost;
  }
  row.rms = errors.rms();
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
    const CirclingScene scene(options.width, options.height, options.radius, brushed);
    const TemporaryFolder folder;
    std::vector<fs::path> files;
    for (const Coding& coding : kCodings) files.push_back(folder.path() / coding.file);
    CirclingRecorder(scene).write(options.frames, files);
    for (const Coding& coding : kCodings) {
      const fs::path file = folder.path() / coding.file;
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
        const TrackResult result = track_all(file, scene);
        decoding.push_back((between - begin) / options.frames);
        tracking.push_back((thread_seconds() - between) / options.frames);
        if (k > 0) continue;
        row.layered = result.summary.layered;
        judge(result.track, scene, row);
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
