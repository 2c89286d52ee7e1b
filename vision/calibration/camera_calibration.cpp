// The camera's calibration: its geometry, and its fit to pictures of a board.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <stdexcept>
#include <utility>

#include "vision/calibration.h"
#include "vision/frame_source.h"
#include "vision/tags/tags.h"

namespace tribotrack::vision {

Point LensModel::project(const Eigen::Vector2d& d) const {
  const double x = d.x(), y = d.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx,
          fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy};
}

Eigen::Matrix2d LensModel::slope(const Eigen::Vector2d& d) const {
  const double x = d.x(), y = d.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double rise = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3));  // d radial / dx = rise x
  Eigen::Matrix2d s;
  s << radial + rise * x * x + 2 * p1 * y + 6 * p2 * x, rise * x * y + 2 * p1 * x + 2 * p2 * y,
      rise * x * y + 2 * p1 * x + 2 * p2 * y, radial + rise * y * y + 6 * p1 * y + 2 * p2 * x;
  s.row(0) *= fx;
  s.row(1) *= fy;
  return s;
}

Eigen::Vector2d LensModel::direction(Point pixel) const {
  Eigen::Vector2d d((pixel.x - cx) / fx, (pixel.y - cy) / fy);
  for (int k = 0; k < 50; ++k) {
    const Point seen = project(d);
    const Eigen::Matrix2d s = slope(d);
    if (!(s.determinant() > 0)) break;
    const Eigen::Vector2d step = s.inverse() * Eigen::Vector2d(pixel.x - seen.x, pixel.y - seen.y);
    d += step;
    if (step.norm() < 1e-13) return d;
  }
  throw std::domain_error("a pixel lies outside what the camera's calibration covers");
}

PlanePoint CameraCalibration::locate(Point pixel, double height_mm) const {
  const Eigen::Vector2d d = lens.direction(pixel);
  // The ray in the plane's axes: pupil + t ray.
  const Eigen::Matrix3d back = plane.rotation.transpose();
  const Eigen::Vector3d pupil = -back * plane.translation;
  const Eigen::Vector3d ray = back * Eigen::Vector3d(d.x(), d.y(), 1);
  const double t = (height_mm - pupil.z()) / ray.z();
  PlanePoint out;
  out.mm = (pupil + t * ray).head<2>();
  // d(mm)/d(x, y): along the ray's change, and back to the plane along the ray.
  Eigen::Matrix2d by_direction;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d change = back.col(i);
    by_direction.col(i) = t * (change - ray * (change.z() / ray.z())).head<2>();
  }
  out.slope = by_direction * lens.slope(d).inverse();
  return out;
}

double scale_in_the_middle(const CameraCalibration& c) {
  return std::sqrt(std::abs(c.locate({0.5 * (c.width - 1), 0.5 * (c.height - 1)}).slope.determinant()));
}

Eigen::Matrix3d plane_homography(const CameraCalibration& c) {
  Eigen::Matrix3d camera = Eigen::Matrix3d::Identity();
  camera(0, 0) = c.lens.fx;
  camera(1, 1) = c.lens.fy;
  camera(0, 2) = c.lens.cx;
  camera(1, 2) = c.lens.cy;
  Eigen::Matrix3d from_plane;
  from_plane << c.plane.rotation.col(0), c.plane.rotation.col(1), c.plane.translation;
  const Eigen::Matrix3d h = (camera * from_plane).inverse();
  return h / h(2, 2);
}

PlanePose turned_to_picture(const CameraCalibration& calibration) {
  CameraCalibration c = calibration;
  // A board's z points away from the camera or towards it; ours towards it.
  if ((c.plane.rotation.transpose() * c.plane.translation).z() > 0) {
    const Eigen::Matrix3d over = Eigen::Vector3d(1, -1, -1).asDiagonal();
    c.plane.rotation = c.plane.rotation * over;
  }
  const Eigen::Matrix2d slope = c.locate({0.5 * (c.width - 1), 0.5 * (c.height - 1)}).slope;
  const double angle = std::atan2(slope(1, 0), slope(0, 0));
  c.plane.rotation = c.plane.rotation * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return c.plane;
}

CalibrationPicture calibration_picture(const std::filesystem::path& input) {
  return {input.string(), open_source(input)->read(0)};
}

std::vector<CalibrationPicture> calibration_pictures(const std::vector<std::filesystem::path>& inputs,
                                                     const CalibrationPicture& plane, int most) {
  std::vector<CalibrationPicture> pictures;
  for (const std::filesystem::path& input : inputs) {
    const auto source = open_source(input);
    const std::int64_t count = source->info().frame_count;
    const std::int64_t taken = std::min<std::int64_t>(count, most);
    for (std::int64_t k = 0; k < taken; ++k) {
      const std::int64_t index = k * count / taken;
      CalibrationPicture picture{input.string(), source->read(index)};
      if (count > 1) picture.name += ", image " + std::to_string(source->number(index));
      if (!std::ranges::equal(picture.picture.levels(), plane.picture.levels()))
        pictures.push_back(std::move(picture));
    }
  }
  return pictures;
}

namespace {

constexpr std::size_t kFewestPictures = 3;  ///< besides the plane's
constexpr double kLeastTurn =
    0.09;  ///< rad between the boards' directions: less does not fix the focal length
constexpr double kWorstFocal = 0.1;  ///< relative sd of the focal length that still means something

constexpr int kNoDistortion =
    cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3 | cv::CALIB_ZERO_TANGENT_DIST;
constexpr int kSquare = cv::CALIB_FIX_ASPECT_RATIO;

/// Terms of the lens that are fitted.
struct Model {
  const char* name;
  int flags, unknowns;
};
constexpr Model kModels[] = {{"no distortion", kNoDistortion | kSquare, 3},
                             {"k1", (kNoDistortion & ~cv::CALIB_FIX_K1) | kSquare, 4},
                             {"k1, k2", cv::CALIB_FIX_K3 | cv::CALIB_ZERO_TANGENT_DIST | kSquare, 5},
                             {"k1, p1, p2", cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3 | kSquare, 6},
                             {"k1, k2, p1, p2", cv::CALIB_FIX_K3 | kSquare, 7},
                             {"k1, k2, p1, p2, k3", kSquare, 8},
                             {"fx and fy apart, k1", kNoDistortion & ~cv::CALIB_FIX_K1, 5},
                             {"fx and fy apart, k1, k2, p1, p2", cv::CALIB_FIX_K3, 8}};

/// Pictures in which the board was found: corners as seen, and where they lie on the board (mm, z = 0).
struct Views {
  std::vector<std::vector<cv::Point2f>> seen;
  std::vector<cv::Point3f> on_board;
  std::vector<std::string> names;
  cv::Size size;
  double corners() const { return static_cast<double>(seen.size() * on_board.size()); }
};

struct Solution {
  cv::Mat camera = cv::Mat::eye(3, 3, CV_64F), distortion = cv::Mat::zeros(5, 1, CV_64F);
  cv::Mat lens_sd;  ///< of fx, fy, ...
  std::vector<cv::Mat> rotations, translations;
  std::vector<double> rms_of_views;  ///< px
  double rms = 0;                    ///< px, of a corner's distance
  double criterion = 0;
  double freedoms = 0;
};

Solution solve(const Views& views, const Model& model) {
  Solution s;
  cv::Mat pose_sd;
  const std::vector<std::vector<cv::Point3f>> boards(views.seen.size(), views.on_board);
  s.rms = cv::calibrateCamera(boards, views.seen, views.size, s.camera, s.distortion, s.rotations,
                              s.translations, s.lens_sd, pose_sd, s.rms_of_views, model.flags,
                              {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 300, 1e-12});
  const double residuals = 2 * views.corners();
  const double unknowns = model.unknowns + 6.0 * static_cast<double>(views.seen.size());
  s.criterion = residuals * std::log(s.rms * s.rms / 2) + unknowns * std::log(residuals);
  s.freedoms = std::max(1.0, residuals - unknowns);
  return s;
}

Eigen::Matrix3d matrix_of(const cv::Mat& rotation) {
  cv::Matx33d r;
  cv::Rodrigues(rotation, r);
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r.val);
}

void require_several_directions(const Solution& s) {
  double widest = 0;
  for (const cv::Mat& a : s.rotations)
    for (const cv::Mat& b : s.rotations)
      widest =
          std::max(widest, std::acos(std::clamp(matrix_of(a).col(2).dot(matrix_of(b).col(2)), -1.0, 1.0)));
  if (widest < kLeastTurn)
    throw InputError(fmt::format(
        "the pictures all show the board from nearly the same direction ({:.1f} degrees apart at "
        "most), which does not fix the focal length; take some with the board tilted by 15 to 45 degrees",
        widest * 180 / CV_PI));
}

/// Lens and the first view's pose.
CameraCalibration calibration_from(const Solution& s, const cv::Mat& rotation, const cv::Mat& translation,
                                   cv::Size size) {
  CameraCalibration c;
  c.width = size.width;
  c.height = size.height;
  const auto camera = [&](int i, int j) { return s.camera.at<double>(i, j); };
  const auto term = [&](int i) { return s.distortion.at<double>(i); };
  c.lens = {camera(0, 0), camera(1, 1), camera(0, 2), camera(1, 2), term(0),
            term(1),      term(2),      term(3),      term(4)};
  c.plane.rotation = matrix_of(rotation);
  for (int i = 0; i < 3; ++i) c.plane.translation(i) = translation.at<double>(i);
  c.mm_per_px = scale_in_the_middle(c);
  return c;
}

/// The scale follows the pose of the plane in its own picture (C = s^2 (J'J)^-1 of six unknowns). An error of
/// the focal length moves that pose and leaves the scale as it is.
double scale_sd(const Views& views, const Solution& s) {
  std::vector<cv::Point2f> projected;
  cv::Mat slopes;  // by rotation 3, translation 3, lens
  cv::projectPoints(views.on_board, s.rotations[0], s.translations[0], s.camera, s.distortion, projected,
                    slopes);
  cv::Mat pose, covariance;
  cv::vconcat(s.rotations[0], s.translations[0], pose);
  const cv::Mat by_pose = slopes.colRange(0, 6);
  cv::invert(by_pose.t() * by_pose, covariance, cv::DECOMP_CHOLESKY);
  covariance *= s.rms * s.rms * views.corners() / s.freedoms;
  cv::Mat slope(6, 1, CV_64F);
  for (int i = 0; i < 6; ++i) {
    const double step = 1e-2 * std::sqrt(covariance.at<double>(i, i));
    const auto scale_at = [&](double off) {
      cv::Mat moved = pose.clone();
      moved.at<double>(i) += off;
      return calibration_from(s, moved.rowRange(0, 3), moved.rowRange(3, 6), views.size).mm_per_px;
    };
    slope.at<double>(i) = (scale_at(step) - scale_at(-step)) / (2 * step);
  }
  return std::sqrt(cv::Mat(slope.t() * covariance * slope).at<double>(0));
}

Views find_views(const CalibrationBoard& board, const CalibrationPicture& plane,
                 const std::vector<CalibrationPicture>& pictures, std::vector<std::string>& left_out) {
  Views views;
  const cv::Size inner(board.columns - 1, board.rows - 1);
  for (int y = 0; y < inner.height; ++y)
    for (int x = 0; x < inner.width; ++x)
      views.on_board.emplace_back(static_cast<float>(x * board.square_mm),
                                  static_cast<float>(y * board.square_mm), 0.0F);
  views.size = {plane.picture.width(), plane.picture.height()};
  const auto add = [&](const CalibrationPicture& picture) {
    std::vector<cv::Point2f> seen = board_corners(picture.picture, inner);
    if (seen.empty()) return false;
    views.seen.push_back(std::move(seen));
    views.names.push_back(picture.name);
    return true;
  };
  if (!add(plane))
    throw InputError(fmt::format(
        "'{}' shows no board of {} x {} squares, and this picture fixes the platform's plane; check "
        "--squares, and that the board is sharp, evenly lit and wholly in the picture",
        plane.name, board.columns, board.rows));
  for (const CalibrationPicture& picture : pictures) {
    if (picture.picture.width() != views.size.width || picture.picture.height() != views.size.height)
      throw InputError(fmt::format(
          "'{}' has {} x {} pixels, but '{}' has {} x {}; all must be of one camera with one setting",
          picture.name, picture.picture.width(), picture.picture.height(), plane.name, views.size.width,
          views.size.height));
    if (!add(picture)) left_out.push_back(fmt::format("'{}': no board found in it", picture.name));
  }
  if (views.seen.size() < kFewestPictures + 1)
    throw InputError(
        fmt::format("the board was found in {} pictures besides the platform's, but at least {} are needed, "
                    "and 10 to 20 are "
                    "good{}; check --squares, and that the board is sharp and wholly in every picture",
                    views.seen.size() - 1, kFewestPictures,
                    left_out.empty() ? "" : "; left out: " + fmt::format("{}", fmt::join(left_out, ", "))));
  return views;
}

}  // namespace

void CalibrationBoard::validate() const {
  if (columns < 3 || rows < 3) throw std::invalid_argument("the board must have at least 3 x 3 squares");
  if (!(square_mm > 0)) throw std::invalid_argument("square_mm must be greater than 0");
  if (!(square_relative_sd >= 0)) throw std::invalid_argument("the squares' sd must not be negative");
}

CalibrationResult calibrate_camera(const CalibrationBoard& board, const CalibrationPicture& plane,
                                   const std::vector<CalibrationPicture>& pictures) {
  board.validate();
  CalibrationResult result;
  const Views views = find_views(board, plane, pictures, result.left_out);

  Solution best;
  for (const Model& model : kModels) {
    Solution s = solve(views, model);
    if (&model == kModels) require_several_directions(s);
    result.tried.push_back(
        fmt::format("{}: rms {:.4f} px, criterion {:.1f}", model.name, s.rms, s.criterion));
    if (!std::isfinite(s.criterion) || (!result.model.empty() && s.criterion >= best.criterion)) continue;
    result.model = model.name;
    best = std::move(s);
  }
  if (result.model.empty())
    throw InputError("no camera explains the pictures of the board; check --squares and --square-mm");
  const double focal = best.camera.at<double>(0, 0);
  // With one focal length OpenCV states the sd of fy alone.
  const double focal_sd = std::max(best.lens_sd.at<double>(0), best.lens_sd.at<double>(1));
  if (!(focal > 0) || !(focal_sd < kWorstFocal * focal))
    throw InputError(fmt::format(
        "the focal length comes out as {:.0f} +- {:.0f} px, which means nothing; take more pictures with "
        "the board tilted by 15 to 45 degrees, in different directions",
        focal, focal_sd));

  result.rms_px = best.rms;
  result.focal_sd_px = focal_sd;
  for (std::size_t v = 0; v < views.seen.size(); ++v)
    result.pictures.push_back({views.names[v], static_cast<int>(views.on_board.size()), best.rms_of_views[v],
                               std::acos(std::min(1.0, std::abs(matrix_of(best.rotations[v])(2, 2))))});
  CameraCalibration& c = result.calibration;
  c = calibration_from(best, best.rotations[0], best.translations[0], views.size);
  c.mm_per_px_sd = std::hypot(scale_sd(views, best), board.square_relative_sd * c.mm_per_px);
  c.plane = turned_to_picture(c);
  return result;
}

}  // namespace tribotrack::vision
