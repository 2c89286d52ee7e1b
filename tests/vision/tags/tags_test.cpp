// Square tags against pictures of them made by hand: cells of known corners, each pixel the mean over a fine
// grid.
#include "vision/tags/tags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "vision/recordings.h"
#include "vision/tracker.h"

// Tags as OpenCV itself draws them, by its interface before 4.8 and by that of 4.8 and later.

namespace tribotrack::vision {

/// One pixel a cell, with the tag's black border of one cell.
template <class Dictionary>
cv::Mat drawn_tag(const Dictionary& family, int id) {
  cv::Mat cells;
  const int side = family.markerSize + 2;
  if constexpr (requires { family.drawMarker(id, side, cells, 1); })
    family.drawMarker(id, side, cells, 1);
  else
    family.generateImageMarker(id, side, cells, 1);
  return cells;
}

namespace {

struct Look {
  std::string family = "apriltag_36h11";
  int id = 7;
  Point centre{80.25, 71.75};    ///< on the fine grid, which the sides lie along at turn 0
  double side = 60, turn = 0.3;  ///< px, rad
  double blur = 0.7;             ///< px, Gaussian sd
  double noise = 0;
  unsigned seed = 1;
};

/// Reflectance of the tag's plane, in sides from its centre: a white margin, the cells, grey beyond.
double reflectance(const cv::Mat& cells, double u, double v) {
  const int n = cells.rows;
  const double margin = 0.5 + 1.5 / n;
  if (std::max(std::abs(u), std::abs(v)) > margin) return 0.45;
  const int column = static_cast<int>(std::floor((u + 0.5) * n)),
            row = static_cast<int>(std::floor((v + 0.5) * n));
  if (column < 0 || row < 0 || column >= n || row >= n) return 0.9;
  return cells.at<uchar>(row, column) > 0 ? 0.9 : 0.08;
}

Picture picture_of(const std::vector<Look>& looks, int width = 170, int height = 150) {
  constexpr int kFine = 8;
  Picture fine(width * kFine, height * kFine, 0.45F);
  for (const Look& look : looks) {
    const auto family = tag_dictionary(look.family);
    const cv::Mat cells = drawn_tag(*family, look.id);
    const double c = std::cos(look.turn), s = std::sin(look.turn);
    for (int y = 0; y < fine.height(); ++y)
      for (int x = 0; x < fine.width(); ++x) {
        const double dx = (x + 0.5) / kFine - 0.5 - look.centre.x,
                     dy = (y + 0.5) / kFine - 0.5 - look.centre.y;
        const double u = (c * dx + s * dy) / look.side, v = (-s * dx + c * dy) / look.side;
        if (std::max(std::abs(u), std::abs(v)) < 0.8)
          fine.at(x, y) = static_cast<float>(reflectance(cells, u, v));
      }
  }
  cv::Mat levels(fine.height(), fine.width(), CV_32F, fine.row(0).data());
  cv::GaussianBlur(levels, levels, {}, looks.front().blur * kFine);
  Picture out(width, height);
  std::mt19937 random(looks.front().seed);
  std::normal_distribution<double> noise;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int j = 0; j < kFine; ++j)
        for (int i = 0; i < kFine; ++i) sum += fine.at(x * kFine + i, y * kFine + j);
      out.at(x, y) = static_cast<float>(200 * sum / (kFine * kFine) + looks.front().noise * noise(random));
    }
  return out;
}

TEST(Tags, LieWhereTheyWereDrawn) {
  for (const char* family : {"4x4_50", "6x6_250", "original", "apriltag_16h5", "apriltag_36h11"})
    for (const double turn : {0.0, 0.3, 0.785, 2.0}) {
      const Look look{.family = family, .turn = turn};
      const auto tags = find_tags(picture_of({look}), family);
      ASSERT_EQ(tags.size(), 1U) << family << " " << turn;
      EXPECT_EQ(tags[0].id, look.id);
      EXPECT_NEAR(tags[0].centre.x, look.centre.x, 0.03) << family << " " << turn;
      EXPECT_NEAR(tags[0].centre.y, look.centre.y, 0.03) << family << " " << turn;
      EXPECT_NEAR(tags[0].side_px, look.side, 0.05) << family << " " << turn;
    }
}

// The edges of a blurred square stay where they are: the side does not depend on the focus.
TEST(Tags, HaveTheSameSideWhateverTheFocus) {
  for (const double blur : {0.3, 0.7, 1.1, 1.5}) {
    const auto tags = find_tags(picture_of({{.blur = blur}}), "apriltag_36h11");
    ASSERT_EQ(tags.size(), 1U) << blur;
    EXPECT_NEAR(tags[0].side_px, 60, 0.06) << blur;
  }
}

TEST(Tags, TellHowWellTheirSideIsKnown) {
  std::vector<double> pulls;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const auto tags = find_tags(picture_of({{.centre = {80.0 + 0.023 * seed, 70.0 + 0.031 * seed},
                                             .turn = 0.05 * seed,
                                             .noise = 6,
                                             .seed = seed}}),
                                "apriltag_36h11");
    ASSERT_EQ(tags.size(), 1U) << seed;
    pulls.push_back((tags[0].side_px - 60) / tags[0].side_sd_px);
  }
  double square = 0;
  for (const double pull : pulls) square += pull * pull / static_cast<double>(pulls.size());
  EXPECT_GT(std::sqrt(square), 0.3);
  EXPECT_LT(std::sqrt(square), 1.8);
}

TEST(Tags, OfAnotherFamilyAreNone) {
  EXPECT_TRUE(find_tags(picture_of({{}}), "4x4_50").empty());
  EXPECT_TRUE(find_tags(Picture(100, 100, 50.0F), "4x4_50").empty());
}

/// A tag that goes round a circle of 3 px, and a disc that lies where it is.
class FollowedTag : public RecordingTest {
 protected:
  static constexpr int kFrames = 24;
  static Point place(int k) {
    const double wt = 2 * 3.14159265358979 * k / 12;
    return {52 + 3 * std::cos(wt), 50 + 3 * std::sin(wt)};
  }
  std::filesystem::path recording(int other = -1) const {
    const auto path = file("tag.cine");
    const auto sink = create_sink(path, {.width = 170, .height = 100, .bits = 8, .frame_rate_hz = 100});
    for (int k = 0; k < kFrames; ++k) {
      std::vector<Look> looks = {{.id = 3,
                                  .centre = place(k),
                                  .side = 48,
                                  .turn = 0.2,
                                  .blur = 0.8,
                                  .noise = 1,
                                  .seed = unsigned(k + 1)}};
      if (other >= 0) looks.push_back({.id = other, .centre = {130, 50}, .side = 40});
      Picture picture = picture_of(looks, 170, 100);
      for (int y = 0; y < 100; ++y)
        for (int x = 0; x < 170; ++x)
          if (other < 0)
            picture.at(x, y) +=
                90.0F * static_cast<float>(std::clamp(12.5 - std::hypot(x - 130.3, y - 50.6), 0.0, 1.0));
      sink->write(picture);
    }
    sink->close();
    return path;
  }
  static TrackOptions options(std::optional<int> id) {
    TrackOptions options;
    options.target = {Target::Kind::disc, {130.3, 50.6, 12}, {}};
    options.marker = {MarkerChoice::Kind::tag, {}, "apriltag_36h11", id};
    return options;
  }
};

TEST_F(FollowedTag, IsThePlatformsMarkAndScale) {
  const auto source = open_source(recording());
  const TrackResult result = track(*source, options({}));
  ASSERT_TRUE(result.summary.tag);
  EXPECT_EQ(result.summary.tag->id, 3);
  EXPECT_NEAR(result.summary.tag->side_px, 48, 0.1);
  ASSERT_EQ(result.track.points.size(), std::size_t{kFrames});
  for (int k = 0; k < kFrames; ++k) {
    const auto& seen = result.track.points[static_cast<std::size_t>(k)].marker;
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->x - result.track.points[0].marker->x, place(k).x - place(0).x, 0.03) << k;
    EXPECT_NEAR(seen->y - result.track.points[0].marker->y, place(k).y - place(0).y, 0.03) << k;
  }
}

TEST_F(FollowedTag, MustBeThereAndBeSaidWhereThereAreSeveral) {
  const auto complaint = [](const std::filesystem::path& path, std::optional<int> id) {
    return refusal_of([&] { track(*open_source(path), options(id)); });
  };
  EXPECT_THAT(complaint(recording(), 11), testing::HasSubstr("no tag apriltag_36h11:11 is seen"));
  EXPECT_THAT(complaint(recording(11), {}), testing::HasSubstr("say which is the mark: apriltag_36h11:3"));
}

}  // namespace
}  // namespace tribotrack::vision
