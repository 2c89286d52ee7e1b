#include "apps/bench/vision/circling.h"

#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <system_error>

#include "apps/bench/vision/recording.h"
#include "vision/frame_sink.h"

namespace tribotrack::bench {

using namespace vision;

namespace fs = std::filesystem;

CirclingScene::CirclingScene(int width, int height, double radius, bool brushed) : brushed_(brushed) {
  scene_.width = width;
  scene_.height = height;
  scene_.disc.radius_px = radius;
  scene_.disc.edge_blur_px = 0.8;
  scene_.disc.scratches = 0;
  scene_.disc.highlight = 0;
  scene_.platform.level = 80;
  scene_.platform.texture_rms = brushed ? 10 : 0;
  const Circle at = mark(0);
  scene_.marker = MarkerAppearance{{at.x, at.y}, at.radius};
}

ScenePose CirclingScene::pose(int frame) const {
  const double turn = 2 * std::numbers::pi * frame / kPoses;
  ScenePose p;
  p.disc = {scene_.width / 2.0 + 14 * std::cos(turn), scene_.height / 2.0 - 14 * std::sin(turn)};
  if (brushed_) p.platform = {5.6 * std::sin(5 * turn), 5.6 * std::cos(5 * turn) - 5.6};
  return p;
}

Circle CirclingScene::part(int frame) const {
  const Point at = pose(frame).disc;
  return {at.x, at.y, scene_.disc.radius_px};
}

Circle CirclingScene::mark(int frame) const {
  const Point platform = pose(frame).platform;
  return {scene_.width / 2.0 - scene_.disc.radius_px - 50 + platform.x, scene_.height / 2.0 + platform.y,
          kMarkRadius};
}

void PositionErrors::see(int frame, const Point& position) {
  const Point truth = scene_.pose(frame).disc;
  const double x = position.x - truth.x, y = position.y - truth.y;
  sum_.x += x;
  sum_.y += y;
  square_ += x * x + y * y;
  ++count_;
}

double PositionErrors::rms() const {
  if (count_ < 4) return 0;
  const double offset = (sum_.x * sum_.x + sum_.y * sum_.y) / count_;
  return std::sqrt(std::max(0.0, square_ - offset) / (2 * (count_ - 1)));
}

void CirclingRecorder::write(int frames, const std::vector<fs::path>& files) {
  const SceneRenderer renderer(scene_.scene());
  for (int k = static_cast<int>(exact_.size()); k < CirclingScene::kPoses; ++k)
    exact_.push_back(renderer.render_exact(0, 0, [p = scene_.pose(k)](double) { return p; }));
  SinkOptions options;
  options.width = scene_.scene().width;
  options.height = scene_.scene().height;
  std::vector<std::unique_ptr<FrameSink>> sinks;
  for (const fs::path& file : files) sinks.push_back(create_sink(file, options));
  for (int k = 0; k < frames; ++k) {
    const Picture frame = recorded(exact_[static_cast<std::size_t>(k) % exact_.size()], CirclingScene::kNoise,
                                   static_cast<std::uint64_t>(k));
    for (const auto& sink : sinks) sink->write(frame);
  }
  for (const auto& sink : sinks) sink->close();
}

std::unique_ptr<FrameSource> open_recording(const fs::path& file) {
  return open_source(file, SourceOptions{kFrameRate});
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "tribotrack-bench-XXXXXX").string();
  if (!::mkdtemp(name.data()))
    throw InputError("no folder can be made in " + fs::temp_directory_path().string());
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace tribotrack::bench
