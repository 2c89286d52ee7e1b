// Boards rendered point by point through a camera that is known, by inverse mapping with many points a pixel.
#include "vision/calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>

namespace tribotrack::vision {
namespace {

/// The camera of the tests: the truth.
struct TrueCamera {
  int width = 360, height = 270;
  double f = 700, cx = 176, cy = 138, k1 = -0.25, k2 = 0.1;

  /// (X/Z, Y/Z) of a pixel by fixed-point iteration, as textbooks undo distortion.
  Eigen::Vector2d direction(double u, double v) const {
    const Eigen::Vector2d distorted((u - cx) / f, (v - cy) / f);
    Eigen::Vector2d d = distorted;
    for (int k = 0; k < 12; ++k) {
      const double r2 = d.squaredNorm();
      d = distorted / (1 + k1 * r2 + k2 * r2 * r2);
    }
    return d;
  }
};

struct Pose {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
};

/// The board's middle at (x, y, z) mm in front of the camera, turned about its own axes.
Pose facing(double about_x, double about_y, double about_z, double x, double y, double z, double half_x,
            double half_y) {
  Pose pose;
  pose.rotation = (Eigen::AngleAxisd(about_x, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(about_y, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(about_z, Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  pose.translation = Eigen::Vector3d(x, y, z) - pose.rotation * Eigen::Vector3d(half_x, half_y, 0);
  return pose;
}

/// Grey level of the board at (x, y) mm from its corner.
using Ink = std::function<double(double, double)>;

Picture photograph(const TrueCamera& camera, const Pose& pose, const Ink& ink, unsigned seed) {
  constexpr int points = 6;
  Picture picture(camera.width, camera.height);
  const Eigen::Matrix3d back = pose.rotation.transpose();
  const Eigen::Vector3d pupil = -back * pose.translation;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      double sum = 0;
      for (int j = 0; j < points; ++j)
        for (int i = 0; i < points; ++i) {
          const Eigen::Vector2d d =
              camera.direction(u + (i + 0.5) / points - 0.5, v + (j + 0.5) / points - 0.5);
          const Eigen::Vector3d ray = back * Eigen::Vector3d(d.x(), d.y(), 1);
          const Eigen::Vector3d at = pupil - pupil.z() / ray.z() * ray;
          sum += ink(at.x(), at.y());
        }
      picture.at(u, v) = static_cast<float>(std::round(sum / (points * points) + noise(random)));
    }
  return picture;
}

constexpr double kSquare = 2.5;  // mm

Ink checkerboard(int columns, int rows) {
  return [=](double x, double y) {
    const int i = static_cast<int>(std::floor(x / kSquare));
    const int j = static_cast<int>(std::floor(y / kSquare));
    if (i < 0 || j < 0 || i >= columns || j >= rows) return 210.0;
    return (i + j) % 2 == 0 ? 40.0 : 210.0;
  };
}

/// Seven poses: the first flat on the platform, turned in its plane; the others tilted.
std::vector<Pose> poses(double half_x, double half_y) {
  return {facing(0.02, -0.03, 0.1, 0.3, -0.2, 62, half_x, half_y),
          facing(0.45, 0.05, 0, 1, 1, 64, half_x, half_y),
          facing(-0.4, 0.1, 0.2, -2, 0, 66, half_x, half_y),
          facing(0.05, 0.5, -0.1, 2, -1, 65, half_x, half_y),
          facing(0, -0.45, 0.1, 1, 2, 63, half_x, half_y),
          facing(0.35, 0.35, 0.3, -1, -1, 67, half_x, half_y),
          facing(-0.3, -0.35, -0.2, 0, 1, 66, half_x, half_y)};
}

/// Distances on the platform between pixels, against the truth: the largest error in px.
double worst_distance_error(const CalibrationResult& result, const TrueCamera& camera, const Pose& platform) {
  const auto truth = [&](Point p) {
    const Eigen::Vector2d d = camera.direction(p.x, p.y);
    const Eigen::Matrix3d back = platform.rotation.transpose();
    const Eigen::Vector3d pupil = -back * platform.translation;
    const Eigen::Vector3d ray = back * Eigen::Vector3d(d.x(), d.y(), 1);
    return Eigen::Vector2d((pupil - pupil.z() / ray.z() * ray).head<2>());
  };
  double worst = 0;
  const Point middle{180, 135};
  for (const Point& p : {Point{60, 50}, Point{300, 50}, Point{60, 220}, Point{300, 220}, Point{180, 40}}) {
    const double found = (result.calibration.locate(p).mm - result.calibration.locate(middle).mm).norm();
    const double expected = (truth(p) - truth(middle)).norm();
    worst = std::max(worst, std::abs(found - expected) / result.calibration.mm_per_px);
  }
  return worst;
}

TEST(CalibrateCamera, ACheckerboardGivesBackCameraAndPlane) {
  const TrueCamera camera;
  const auto where = poses(4.5 * kSquare, 3.5 * kSquare);
  std::vector<CalibrationPicture> pictures;
  for (std::size_t k = 0; k < where.size(); ++k)
    pictures.push_back({"picture" + std::to_string(k),
                        photograph(camera, where[k], checkerboard(9, 7), static_cast<unsigned>(k))});
  const CalibrationPicture plane = std::move(pictures.front());
  pictures.erase(pictures.begin());
  CalibrationBoard board;
  board.columns = 9;
  board.rows = 7;
  board.square_mm = kSquare;
  const CalibrationResult r = calibrate_camera(board, plane, pictures);
  EXPECT_TRUE(r.left_out.empty());
  EXPECT_EQ(r.pictures.size(), 7u);
  EXPECT_EQ(r.pictures[0].corners, 48);
  EXPECT_LT(r.rms_px, 0.1);
  const double f_sd = r.focal_sd_px;
  EXPECT_NEAR(r.calibration.lens.fx, camera.f, 5 * f_sd);
  EXPECT_LT(f_sd, 0.01 * camera.f);
  const double error = worst_distance_error(r, camera, where[0]);
  EXPECT_LT(error, 0.02);
  EXPECT_NE(r.model, "no distortion") << "0.25 of distortion pays";
}

}  // namespace
}  // namespace tribotrack::vision
