#include "vision/overlay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <utility>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

class Overlay : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("overlay_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    TrackOptions options;
    options.target.kind = Target::Kind::disc;
    options.target.disc = {30, 40, 12};
    result_ = track(source_, options);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
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
  write_overlay(source_, result_, folder_ / "path.png");
  const auto source = open_source(folder_ / "path.png");
  EXPECT_EQ(source->info().width, 4 * 121);
  EXPECT_EQ(source->info().height, 4 * 81);
  EXPECT_TRUE(source->info().colour);
  // On the path, away from the text, the picture is brighter than the plain ground.
  const Picture shown = source->read(0);
  const auto at = [&](double x, double y) {
    return shown.at(static_cast<int>((x + 0.5) * 4), static_cast<int>((y + 0.5) * 4));
  };
  EXPECT_GT(at(60, 40), at(60, 60) + 50);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1) << "nothing else is left";
}

TEST_F(Overlay, VideoHasEveryAnalysedFrame) {
  write_overlay(source_, result_, folder_ / "path.mp4");
  const auto source = open_source(folder_ / "path.mp4");
  EXPECT_EQ(source->info().frame_count, 20);
  EXPECT_EQ(source->info().width, 4 * 121);
}

TEST_F(Overlay, UnknownEndingAndUnwritableFolderAreRefused) {
  EXPECT_THROW(write_overlay(source_, result_, folder_ / "path.gif"), InputError);
  EXPECT_THROW(write_overlay(source_, result_, folder_ / "none" / "path.png"), InputError);
}

/// Width and height as a baseline JPEG's frame header (SOF0) states them.
std::pair<int, int> size_of_jpeg(const std::vector<unsigned char>& bytes) {
  for (std::size_t i = 0; i + 8 < bytes.size(); ++i)
    if (bytes[i] == 0xff && bytes[i + 1] == 0xc0)
      return {bytes[i + 7] << 8 | bytes[i + 8], bytes[i + 5] << 8 | bytes[i + 6]};
  return {0, 0};
}

TEST_F(Overlay, FirstFrameIsAJpegNoLargerThanAsked) {
  const auto [width, height] = size_of_jpeg(first_frame_jpeg(source_, 0));
  EXPECT_EQ(width, source_.info().width);
  EXPECT_EQ(height, source_.info().height);
  const auto [narrow, low] = size_of_jpeg(first_frame_jpeg(source_, 0, 60));
  EXPECT_EQ(std::max(narrow, low), 60);
  EXPECT_NEAR(static_cast<double>(narrow) / low, static_cast<double>(width) / height, 0.05);
}

}  // namespace
}  // namespace tribotrack::vision
