// What is shown of every stage must be what the stage used: known scenes, their true background, disc and
// noise.
#include "vision/stages/stages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>

#include "vision/layered_scenes.h"

namespace tribotrack::vision {
namespace {

using test::SceneSource;
using test::SlidingScene;

/// Keeps everything by its name, pictures of frames as name@frame.
class Shown : public DebugSink {
 public:
  void show(const StagePicture& picture) override {
    const std::string at = picture.frame ? "@" + std::to_string(*picture.frame) : "";
    EXPECT_TRUE(pictures.emplace(picture.name + at, picture).second) << picture.name << at << " shown twice";
  }
  std::map<std::string, StagePicture> pictures;
};

/// A scene tracked, and what was shown of it.
struct Looked {
  SlidingScene scene;
  TrackOptions options;
  Shown shown;
  TrackResult result;
  Looked() {
    scene.frames = 120;
    options.marker = {MarkerChoice::Kind::circle, {22 + scene.circle_px, 30, 12}};
    options.layers = Layers::on;
  }
  void track_and_show() {
    SceneSource source(scene);
    options.debug = &shown;
    result = track(source, options);
  }
};

/// Once for all tests that change nothing of it.
const Looked& ordinary() {
  static const auto looked = [] {
    auto out = std::make_unique<Looked>();
    out->track_and_show();
    return out;
  }();
  return *looked;
}

double rms(const Picture& picture) {
  double n = 0, squares = 0;
  for (const float level : picture.levels())
    if (std::isfinite(level)) {
      ++n;
      squares += static_cast<double>(level) * level;
    }
  return std::sqrt(squares / n);
}

TEST(DebugPictures, TheLayersLeaveTheNoiseAndTheSingleTemplateMore) {
  const Looked& looked = ordinary();
  ASSERT_TRUE(looked.result.summary.layered);
  const double noise =
      std::hypot(looked.scene.scene.read_noise, std::sqrt(1.0 / 12));  // rounding to whole levels
  int frames = 0;
  for (const auto& [name, picture] : looked.shown.pictures) {
    if (picture.name != "layers_residual") continue;
    ++frames;
    const StagePicture& single =
        looked.shown.pictures.at("first_pass_residual@" + std::to_string(*picture.frame));
    EXPECT_TRUE(picture.zero_centred);
    EXPECT_NEAR(rms(picture.levels), noise, 0.05 * noise) << name;
    if (!picture.why_frame.starts_with("first")) {
      EXPECT_GT(rms(single.levels), 1.1 * rms(picture.levels)) << name;
    }
  }
  EXPECT_GE(frames, 3);
}

}  // namespace
}  // namespace tribotrack::vision
