// The camera's calibration: its geometry, and its fit to pictures of a board.
#include <fmt/core.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <stdexcept>

#include "vision/calibration.h"
#include "vision/calibration/corners.h"
#include "vision/frame_source.h"
#include "vision/io/files.h"
#include "vision/kernels/dense.h"

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

double CameraCalibration::distance_mm() const {
  return std::abs((plane.rotation.transpose() * plane.translation).z());
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

/// Lens terms in the order of OpenCV's distortion vector: k1, k2, p1, p2, k3.
struct Model {
  const char* name;
  int flags;
  std::vector<int> terms;
  bool one_focal_length;
};

std::vector<Model> models() {
  constexpr int none = cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3 | cv::CALIB_ZERO_TANGENT_DIST;
  constexpr int square = cv::CALIB_FIX_ASPECT_RATIO;
  return {{"no distortion", none | square, {}, true},
          {"k1", (none & ~cv::CALIB_FIX_K1) | square, {0}, true},
          {"k1, k2", (none & ~cv::CALIB_FIX_K1 & ~cv::CALIB_FIX_K2) | square, {0, 1}, true},
          {"k1, p1, p2", cv::CALIB_FIX_K2 | cv::CALIB_FIX_K3 | square, {0, 2, 3}, true},
          {"k1, k2, p1, p2", cv::CALIB_FIX_K3 | square, {0, 1, 2, 3}, true},
          {"k1, k2, p1, p2, k3", square, {0, 1, 2, 3, 4}, true},
          {"fx and fy apart, k1", none & ~cv::CALIB_FIX_K1, {0}, false},
          {"fx and fy apart, k1, k2, p1, p2", cv::CALIB_FIX_K3, {0, 1, 2, 3}, false}};
}

struct Solution {
  cv::Mat camera, distortion;
  std::vector<cv::Mat> rotations, translations;
  double rss = 0;  ///< px^2
  double criterion = 0;
  int unknowns = 0;
};

struct Views {
  std::vector<std::vector<cv::Point2f>> seen;
  std::vector<std::vector<cv::Point3f>> on_board;
  std::vector<std::string> names;
  cv::Size size;
  std::size_t corners() const {
    std::size_t n = 0;
    for (const auto& v : seen) n += v.size();
    return n;
  }
};

Solution solve(const Views& views, const Model& model) {
  Solution s;
  s.camera = cv::Mat::eye(3, 3, CV_64F);
  s.distortion = cv::Mat::zeros(5, 1, CV_64F);
  const double rms = cv::calibrateCamera(views.on_board, views.seen, views.size, s.camera, s.distortion,
                                         s.rotations, s.translations, model.flags,
                                         {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 300, 1e-12});
  const auto corners = static_cast<double>(views.corners());
  s.rss = rms * rms * corners;
  s.unknowns = (model.one_focal_length ? 3 : 4) + static_cast<int>(model.terms.size()) +
               6 * static_cast<int>(views.seen.size());
  s.criterion = 2 * corners * std::log(s.rss / (2 * corners)) + s.unknowns * std::log(2 * corners);
  return s;
}

Eigen::Vector3d normal_of(const cv::Mat& rotation) {
  cv::Mat r;
  cv::Rodrigues(rotation, r);
  return {r.at<double>(0, 2), r.at<double>(1, 2), r.at<double>(2, 2)};
}

void require_several_directions(const Solution& s) {
  double widest = 0;
  for (const cv::Mat& a : s.rotations)
    for (const cv::Mat& b : s.rotations)
      widest = std::max(widest, std::acos(std::clamp(normal_of(a).dot(normal_of(b)), -1.0, 1.0)));
  if (widest < kLeastTurn)
    throw InputError(fmt::format(
        "the pictures all show the board from nearly the same direction ({:.1f} degrees apart at "
        "most), which does not fix the focal length; take some with the board tilted by 15 to 45 degrees",
        widest * 180 / CV_PI));
}

/// Normal matrix of all unknowns by OpenCV's own derivatives, then its inverse's block of lens and plane.
Eigen::MatrixXd covariance_of(const Views& views, const Solution& s, const Model& model) {
  const int lens = (model.one_focal_length ? 3 : 4) + static_cast<int>(model.terms.size());
  const int all = lens + 6 * static_cast<int>(views.seen.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(all, all);
  for (std::size_t v = 0; v < views.seen.size(); ++v) {
    std::vector<cv::Point2f> projected;
    cv::Mat slopes;  // rotation 3, translation 3, fx, fy, cx, cy, k1, k2, p1, p2, k3
    cv::projectPoints(views.on_board[v], s.rotations[v], s.translations[v], s.camera, s.distortion, projected,
                      slopes);
    const double aspect = s.camera.at<double>(1, 1) / s.camera.at<double>(0, 0);
    for (int row = 0; row < slopes.rows; ++row) {
      Eigen::VectorXd d = Eigen::VectorXd::Zero(all);
      const double* from = slopes.ptr<double>(row);
      int k = 0;
      if (model.one_focal_length) {
        d(k++) = from[6] + aspect * from[7];
      } else {
        d(k++) = from[6];
        d(k++) = from[7];
      }
      d(k++) = from[8];
      d(k++) = from[9];
      for (const int term : model.terms) d(k++) = from[10 + term];
      for (int i = 0; i < 6; ++i) d(lens + 6 * static_cast<int>(v) + i) = from[i];
      normal.selfadjointView<Eigen::Lower>().rankUpdate(d);
    }
  }
  normal = Eigen::MatrixXd(normal.selfadjointView<Eigen::Lower>());
  const double freedoms = std::max(1.0, 2.0 * static_cast<double>(views.corners()) - s.unknowns);
  // Scaled by its diagonal: focal lengths and distortions differ by many powers of ten.
  const Eigen::VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd inverse =
      solve_spd(scale.asDiagonal() * normal * scale.asDiagonal(), Eigen::MatrixXd::Identity(all, all));
  return (scale.asDiagonal() * inverse * scale.asDiagonal() * (s.rss / freedoms))
      .topLeftCorner(lens + 6, lens + 6);
}

/// Lens and the first view's pose from the parameters in the order of covariance_of.
CameraCalibration calibration_from(const Eigen::VectorXd& p, const Model& model, double aspect,
                                   cv::Size size) {
  CameraCalibration c;
  c.width = size.width;
  c.height = size.height;
  int k = 0;
  c.lens.fx = p(k++);
  c.lens.fy = model.one_focal_length ? aspect * c.lens.fx : p(k++);
  c.lens.cx = p(k++);
  c.lens.cy = p(k++);
  double* const terms[] = {&c.lens.k1, &c.lens.k2, &c.lens.p1, &c.lens.p2, &c.lens.k3};
  for (const int term : model.terms) *terms[term] = p(k++);
  const cv::Mat rotation = (cv::Mat_<double>(3, 1) << p(k), p(k + 1), p(k + 2));
  cv::Mat matrix;
  cv::Rodrigues(rotation, matrix);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c.plane.rotation(i, j) = matrix.at<double>(i, j);
  c.plane.translation = p.segment<3>(k + 3);
  return c;
}

Eigen::VectorXd parameters_of(const Solution& s, const Model& model) {
  std::vector<double> p{s.camera.at<double>(0, 0)};
  if (!model.one_focal_length) p.push_back(s.camera.at<double>(1, 1));
  p.push_back(s.camera.at<double>(0, 2));
  p.push_back(s.camera.at<double>(1, 2));
  for (const int term : model.terms) p.push_back(s.distortion.at<double>(term));
  for (const cv::Mat& pose : {s.rotations.front(), s.translations.front()})
    for (int i = 0; i < 3; ++i) p.push_back(pose.at<double>(i));
  return Eigen::Map<Eigen::VectorXd>(p.data(), static_cast<Eigen::Index>(p.size()));
}

std::vector<std::string> names_of(const Model& model) {
  std::vector<std::string> names =
      model.one_focal_length ? std::vector<std::string>{"f_px"} : std::vector<std::string>{"fx_px", "fy_px"};
  names.insert(names.end(), {"cx_px", "cy_px"});
  for (const int term : model.terms)
    names.emplace_back(std::array{"k1", "k2", "p1", "p2", "k3"}[static_cast<std::size_t>(term)]);
  names.insert(names.end(), {"rotation_x_rad", "rotation_y_rad", "rotation_z_rad", "x_mm", "y_mm", "z_mm"});
  return names;
}

std::vector<PictureResult> table_of(const Views& views, const Solution& s) {
  std::vector<PictureResult> table;
  for (std::size_t v = 0; v < views.seen.size(); ++v) {
    std::vector<cv::Point2f> projected;
    cv::projectPoints(views.on_board[v], s.rotations[v], s.translations[v], s.camera, s.distortion,
                      projected);
    PictureResult r;
    r.name = views.names[v];
    r.corners = static_cast<int>(projected.size());
    for (std::size_t i = 0; i < projected.size(); ++i) {
      const double off = cv::norm(projected[i] - views.seen[v][i]);
      r.rms_px += off * off / r.corners;
      r.worst_px = std::max(r.worst_px, off);
    }
    r.rms_px = std::sqrt(r.rms_px);
    r.tilt_rad = std::acos(std::min(1.0, std::abs(normal_of(s.rotations[v]).z())));
    table.push_back(r);
  }
  return table;
}

void add(Views& views, const CalibrationPicture& picture, BoardView view) {
  views.seen.push_back(std::move(view.seen));
  views.on_board.push_back(std::move(view.on_board));
  views.names.push_back(picture.name);
}

Views find_views(const CalibrationBoard& board, const CalibrationPicture& plane,
                 const std::vector<CalibrationPicture>& pictures, std::vector<std::string>& left_out) {
  Views views;
  views.size = {plane.picture.width(), plane.picture.height()};
  BoardView on_platform = find_board(board, plane.picture);
  if (on_platform.seen.empty())
    throw InputError(in_quotes(plane.name) + " shows no board of " + std::to_string(board.columns) + " x " +
                     std::to_string(board.rows) +
                     " squares, and this picture fixes the platform's plane; check --squares, and that "
                     "the board is sharp, evenly lit and wholly in the picture");
  add(views, plane, std::move(on_platform));
  for (const CalibrationPicture& picture : pictures) {
    if (picture.picture.width() != views.size.width || picture.picture.height() != views.size.height)
      throw InputError(in_quotes(picture.name) + " has " + std::to_string(picture.picture.width()) + " x " +
                       std::to_string(picture.picture.height()) + " pixels, but " + in_quotes(plane.name) +
                       " has " + std::to_string(views.size.width) + " x " +
                       std::to_string(views.size.height) + "; all must be of one camera with one setting");
    BoardView view = find_board(board, picture.picture);
    if (view.seen.empty())
      left_out.push_back(in_quotes(picture.name) + ": no board found in it");
    else
      add(views, picture, std::move(view));
  }
  if (views.seen.size() < kFewestPictures + 1) {
    std::string text = "the board was found in " + std::to_string(views.seen.size() - 1) +
                       " pictures besides the platform's, but at least " + std::to_string(kFewestPictures) +
                       " are needed, and 10 to 20 are good";
    if (!left_out.empty()) text += "; left out: " + left_out.front();
    if (left_out.size() > 1) text += " and " + std::to_string(left_out.size() - 1) + " more";
    throw InputError(text + "; check --squares, and that the board is sharp and wholly in every picture");
  }
  return views;
}

}  // namespace

CalibrationResult calibrate_camera(const CalibrationBoard& board, const CalibrationPicture& plane,
                                   const std::vector<CalibrationPicture>& pictures) {
  board.validate();
  CalibrationResult result;
  const Views views = find_views(board, plane, pictures, result.left_out);

  const std::vector<Model> candidates = models();
  const Model* best = nullptr;
  Solution solution;
  for (const Model& model : candidates) {
    Solution s = solve(views, model);
    if (&model == &candidates.front()) require_several_directions(s);
    result.tried.push_back(fmt::format("{}: rms {:.4f} px, criterion {:.1f}", model.name,
                                       std::sqrt(s.rss / static_cast<double>(views.corners())), s.criterion));
    if (std::isfinite(s.criterion) && (!best || s.criterion < solution.criterion)) {
      best = &model;
      solution = std::move(s);
    }
  }
  if (!best)
    throw InputError("no camera explains the pictures of the board; check --squares and --square-mm");

  result.model = best->name;
  result.rms_px = std::sqrt(solution.rss / static_cast<double>(views.corners()));
  result.pictures = table_of(views, solution);
  result.covariance_of = names_of(*best);
  result.covariance = covariance_of(views, solution, *best);
  const double focal = solution.camera.at<double>(0, 0);
  const double focal_sd = std::sqrt(std::max(0.0, result.covariance(0, 0)));
  if (!(focal > 0) || !(focal_sd < kWorstFocal * focal))
    throw InputError(fmt::format(
        "the focal length comes out as {:.0f} +- {:.0f} px, which means nothing; take more pictures with "
        "the board tilted by 15 to 45 degrees, in different directions",
        focal, focal_sd));

  const Eigen::VectorXd p = parameters_of(solution, *best);
  const double aspect = solution.camera.at<double>(1, 1) / focal;
  CameraCalibration& c = result.calibration;
  c = calibration_from(p, *best, aspect, views.size);
  c.mm_per_px = scale_in_the_middle(c);
  // Its slope along every parameter, by central differences of a thousandth of that one's sd.
  Eigen::VectorXd slope(p.size());
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    const double step = std::max(1e-12, 1e-2 * std::sqrt(std::max(0.0, result.covariance(i, i))));
    Eigen::VectorXd up = p, down = p;
    up(i) += step;
    down(i) -= step;
    slope(i) = (scale_in_the_middle(calibration_from(up, *best, aspect, views.size)) -
                scale_in_the_middle(calibration_from(down, *best, aspect, views.size))) /
               (2 * step);
  }
  c.mm_per_px_sd = std::hypot(std::sqrt(std::max(0.0, slope.dot(result.covariance * slope))),
                              board.square_relative_sd * c.mm_per_px);
  c.plane = turned_to_picture(c);
  return result;
}

}  // namespace tribotrack::vision
