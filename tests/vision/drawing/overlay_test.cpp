#include "vision/overlay.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

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

TEST_F(Overlay, FirstFrameIsAJpegNoLargerThanAsked) {
  const cv::Mat whole = cv::imdecode(first_frame_jpeg(source_, 0), cv::IMREAD_UNCHANGED);
  const cv::Mat reduced = cv::imdecode(first_frame_jpeg(source_, 0, 60), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(whole.cols, source_.info().width);
  EXPECT_EQ(whole.channels(), 1);
  EXPECT_EQ(std::max(reduced.cols, reduced.rows), 60);
  cv::Mat same;
  cv::resize(whole, same, reduced.size(), 0, 0, cv::INTER_AREA);
  EXPECT_LT(cv::norm(same, reduced, cv::NORM_L1) / static_cast<double>(same.total()), 4);
}

}  // namespace
}  // namespace tribotrack::vision
