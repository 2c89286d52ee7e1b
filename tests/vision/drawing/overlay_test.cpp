#include "vision/overlay.h"

#include <gtest/gtest.h>

#include "vision/analytic_scene.h"
#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

class Overlay : public RecordingTest {
 protected:
  void SetUp() override {
    TrackOptions options;
    options.target.kind = Target::Kind::disc;
    options.target.disc = {30, 40, 12};
    result_ = track(source_, options);
  }

  test::RenderedSource source_{121, 81, 20, [](std::int64_t k) {
                                 test::TestScene scene;
                                 scene.width = 121;
                                 scene.height = 81;
                                 scene.discs = {{30.0 + 3 * static_cast<double>(k), 40, 12, 0, 150, {}}};
                                 return scene.render();
                               }};
  TrackResult result_;
};

TEST_F(Overlay, PictureShowsThePathInColourAndIsEnlarged) {
  write_overlay(source_, result_, file("path.png"));
  const auto source = open_source(file("path.png"));
  EXPECT_EQ(source->info().width, 4 * 121);
  EXPECT_EQ(source->info().height, 4 * 81);
  EXPECT_TRUE(source->info().colour);
  // On the path, away from the text, the picture is brighter than the plain ground.
  const Picture shown = source->read(0);
  const auto at = [&](double x, double y) {
    return shown.at(static_cast<int>((x + 0.5) * 4), static_cast<int>((y + 0.5) * 4));
  };
  EXPECT_GT(at(60, 40), at(60, 60) + 50);
  EXPECT_EQ(files_in_folder(), 1U) << "nothing else is left";
}

TEST_F(Overlay, VideoHasEveryAnalysedFrame) {
  write_overlay(source_, result_, file("path.mp4"));
  const auto source = open_source(file("path.mp4"));
  EXPECT_EQ(source->info().frame_count, 20);
  EXPECT_EQ(source->info().width, 4 * 121);
}

TEST_F(Overlay, FirstFrameIsAJpegNoLargerThanAsked) {
  const auto opened = [this](const std::vector<unsigned char>& bytes) {
    write_bytes(file("first.jpg"), bytes);
    return open_source(file("first.jpg"));
  };
  EXPECT_EQ(opened(first_frame_jpeg(source_, 0))->info().width, 121);
  const auto narrow = opened(first_frame_jpeg(source_, 0, 60));
  EXPECT_EQ(narrow->info().width, 60);
  EXPECT_NEAR(narrow->info().height, 40, 1);
}

}  // namespace
}  // namespace tribotrack::vision
