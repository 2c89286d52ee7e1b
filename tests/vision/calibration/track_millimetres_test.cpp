#include "vision/millimetres.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

namespace tribotrack::vision {
namespace {

/// A part that moves 100 px along x, a marker that circles with 3 px.
Track example() {
  Track track;
  track.has_marker = true;
  for (int k = 0; k < 20; ++k) {
    TrackPoint p;
    p.status = TrackStatus::ok;
    p.x = 200 + 5 * k;
    p.y = 150 - k;
    p.sigma_x = 0.01;
    p.sigma_y = 0.02;
    p.rho_xy = 0.3;
    p.marker = MarkerPoint{40 + 3 * std::cos(0.5 * k), 50 + 3 * std::sin(0.5 * k), 0.005, 1};
    track.points.push_back(p);
  }
  return track;
}

TEST(PlaceTrack, WithOneScaleIsATurnAndAFactor) {
  const Track track = example();
  const Scale scale{0.02, 1e-5, "given"};
  // From pixels (x right, y down) to millimetres (y up, turned by -xi).
  Eigen::Matrix2d to_mm;
  to_mm << std::cos(0.7), -std::sin(0.7), -std::sin(0.7), -std::cos(0.7);
  to_mm *= scale.mm_per_px;
  const auto placed = place_track(track, {scale, ScalePlane::part_top, std::nullopt}, 0.7);
  ASSERT_EQ(placed.size(), track.points.size());
  const TrackPoint& first = track.points.front();
  for (std::size_t k = 0; k < placed.size(); ++k) {
    ASSERT_TRUE(placed[k]);
    const TrackPoint& p = track.points[k];
    const Eigen::Vector2d moved(p.x - first.x - (p.marker->x - first.marker->x),
                                p.y - first.y - (p.marker->y - first.marker->y));
    Eigen::Matrix2d spread;
    spread << p.sigma_x * p.sigma_x, p.rho_xy * p.sigma_x * p.sigma_y, p.rho_xy * p.sigma_x * p.sigma_y,
        p.sigma_y * p.sigma_y;
    spread.diagonal().array() += p.marker->sigma * p.marker->sigma;
    EXPECT_LT((placed[k]->mm - to_mm * moved).norm(), 1e-12);
    const Eigen::Matrix2d expected = to_mm * spread * to_mm.transpose();
    EXPECT_LT((placed[k]->covariance - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST(PlaceTrack, BeginsWhereTheMarkerIsSeenAndHasNoPlaceWhereOneIsMissing) {
  Track track = example();
  track.points[0].marker.reset();
  track.points[3].status = TrackStatus::lost;
  const auto placed = place_track(track, {{1, 0, "given"}, ScalePlane::part_top, std::nullopt}, 0);
  EXPECT_FALSE(placed[0] || placed[3]);
  ASSERT_TRUE(placed[1]);
  EXPECT_EQ(placed[1]->mm.norm(), 0);
}

TEST(PlaceTrack, ParallaxMakesTheMarkersMillimetresLarger) {
  // 0.8 mm at 100 mm distance: 0.8 % in scale.
  const Parallax parallax{0.8, 100};
  const PlaneGeometry by_top({0.02, 1e-5, "part's diameter"}, ScalePlane::part_top, parallax);
  EXPECT_DOUBLE_EQ(by_top.part_scale().mm_per_px, 0.02);
  EXPECT_DOUBLE_EQ(by_top.marker_scale().mm_per_px, 0.02 / 0.992);
  EXPECT_DOUBLE_EQ(by_top.marker_scale().sd, 1e-5 / 0.992);
  const PlaneGeometry by_ruler({0.02, 0, "given"}, ScalePlane::platform, parallax);
  EXPECT_DOUBLE_EQ(by_ruler.part_scale().mm_per_px, 0.02 * 0.992);
  EXPECT_DOUBLE_EQ(by_ruler.marker_scale().mm_per_px, 0.02);

  const Track track = example();
  const auto placed = place_track(track, by_top, 0);
  const TrackPoint &a = track.points[0], &b = track.points[6];
  EXPECT_NEAR(placed[6]->mm.x(), 0.02 * (b.x - a.x) - 0.02 / 0.992 * (b.marker->x - a.marker->x), 1e-12);
  EXPECT_NEAR(placed[6]->mm.y(), -0.02 * (b.y - a.y) + 0.02 / 0.992 * (b.marker->y - a.marker->y), 1e-12);
}

/// Looks down from 100 mm, tilted by 0.1 rad, with strong distortion.
CameraCalibration tilted() {
  CameraCalibration c;
  c.width = 640;
  c.height = 480;
  c.lens = {2000, 2010, 322, 236, -0.3, 0.4, 0.001, -0.002, 0};
  c.plane.rotation =
      (Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()) *
       Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  c.plane.translation = {1, -2, 100};
  c.plane = turned_to_picture(c);
  c.mm_per_px = scale_in_the_middle(c);
  return c;
}

Point seen(const CameraCalibration& c, const Eigen::Vector3d& on_platform) {
  const Eigen::Vector3d v = c.plane.rotation * on_platform + c.plane.translation;
  return c.lens.project(v.head<2>() / v.z());
}

TEST(CameraCalibration, FindsThePlaceFromItsPicture) {
  const CameraCalibration c = tilted();
  for (const double height : {0.0, 0.8, 3.0})
    for (double x = -10; x <= 10; x += 4)
      for (double y = -8; y <= 8; y += 4) {
        const PlanePoint found = c.locate(seen(c, {x, y, height}), height);
        EXPECT_NEAR(found.mm.x(), x, 1e-9);
        EXPECT_NEAR(found.mm.y(), y, 1e-9);
      }
}

TEST(CameraCalibration, SlopesAreThoseOfDifferences) {
  const CameraCalibration c = tilted();
  const Point at{150, 400};
  const double h = 1e-3;
  const PlanePoint point = c.locate(at, 0.8);
  const Eigen::Vector2d by_x =
      (c.locate({at.x + h, at.y}, 0.8).mm - c.locate({at.x - h, at.y}, 0.8).mm) / (2 * h);
  const Eigen::Vector2d by_y =
      (c.locate({at.x, at.y + h}, 0.8).mm - c.locate({at.x, at.y - h}, 0.8).mm) / (2 * h);
  EXPECT_NEAR((point.slope.col(0) - by_x).norm(), 0, 1e-9);
  EXPECT_NEAR((point.slope.col(1) - by_y).norm(), 0, 1e-9);
}

TEST(CameraCalibration, AxesArePicturesAxesInTheMiddle) {
  const CameraCalibration c = tilted();
  const Eigen::Matrix2d slope = c.locate({319.5, 239.5}).slope;
  EXPECT_NEAR(slope(1, 0), 0, 1e-12) << "x right";
  EXPECT_GT(slope(0, 0), 0);
  EXPECT_LT(slope(1, 1), 0) << "y up, pixels down";
  EXPECT_NEAR(c.mm_per_px, 100.0 / 2000, 0.002);
  EXPECT_NEAR(c.plane.rotation.determinant(), 1, 1e-12);
}

TEST(CameraCalibration, BeyondTheFoldOfTheDistortionThereIsNoPlace) {
  CameraCalibration c = tilted();
  c.lens = {500, 500, 320, 240, -0.5, 0, 0, 0, 0};
  EXPECT_THROW(c.locate({3000, 240}), std::domain_error);
}

TEST(PlaceTrack, ThroughACameraIsWhereThingsWere) {
  const CameraCalibration c = tilted();
  Track track;
  track.has_marker = true;
  for (int k = 0; k < 10; ++k) {
    TrackPoint p;
    p.status = TrackStatus::ok;
    const Point part = seen(c, {-5.0 + k, 0.3 * k, 0.8});
    const Point marker = seen(c, {6 + 0.1 * k, 5, 0});
    p.x = part.x;
    p.y = part.y;
    p.sigma_x = p.sigma_y = 0.01;
    p.marker = MarkerPoint{marker.x, marker.y, 0, 1};
    track.points.push_back(p);
  }
  const PlaneGeometry geometry(c, 0.8);
  const auto placed = place_track(track, geometry, 0);
  for (int k = 0; k < 10; ++k) {
    EXPECT_NEAR(placed[static_cast<std::size_t>(k)]->mm.x(), 0.9 * k, 1e-9);
    EXPECT_NEAR(placed[static_cast<std::size_t>(k)]->mm.y(), 0.3 * k, 1e-9);
    EXPECT_NEAR(std::sqrt(placed[static_cast<std::size_t>(k)]->covariance(0, 0)), 0.01 * c.mm_per_px, 1e-4);
  }
}

}  // namespace
}  // namespace tribotrack::vision
