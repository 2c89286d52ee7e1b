#include "vision/stages/stage_clock.h"

#include <gtest/gtest.h>

#include <chrono>

#include "vision/layered_scenes.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

double seconds_of(const std::vector<StageTime>& times, Stage stage) {
  for (const StageTime& time : times)
    if (time.name == to_string(stage)) return time.seconds;
  return 0;
}

double total(const std::vector<StageTime>& times) {
  double sum = 0;
  for (const StageTime& time : times) sum += time.seconds;
  return sum;
}

TEST(StageClock, StagesOfATrackAddUpToItsTime) {
  test::SlidingScene scene;
  scene.frames = 60;
  test::SceneSource source(scene);
  TrackOptions options;
  options.marker = {MarkerChoice::Kind::circle, {22 + scene.circle_px, 30, 12}};
  options.layers = Layers::on;
  const auto begun = std::chrono::steady_clock::now();
  const TrackResult result = track(source, options);
  const double taken = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  EXPECT_LE(total(result.stage_times), taken);
  EXPECT_GT(total(result.stage_times), 0.95 * taken);
  for (const Stage stage : {Stage::reading, Stage::camera, Stage::finding, Stage::setup, Stage::part,
                            Stage::marker, Stage::radius, Stage::layers_learning, Stage::layers_measuring})
    EXPECT_GT(seconds_of(result.stage_times, stage), 0) << to_string(stage);
  EXPECT_EQ(seconds_of(result.stage_times, Stage::lamp), 0);
  EXPECT_EQ(seconds_of(result.stage_times, Stage::debug_pictures), 0);
}

}  // namespace
}  // namespace tribotrack::vision
