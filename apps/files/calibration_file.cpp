#include "apps/files/calibration_file.h"

#include <fmt/format.h>

#include "apps/json/json_place.h"
#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace {

template <class Matrix>
Json matrix_json(const Matrix& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(row);
  }
  return rows;
}

Json pictures_json(const std::vector<vision::PictureResult>& pictures) {
  Json rows = Json::array();
  for (const auto& p : pictures)
    rows.push_back({{"picture", p.name},
                    {"corners", p.corners},
                    {"rms_px", p.rms_px},
                    {"worst_px", p.worst_px},
                    {"tilt_rad", p.tilt_rad}});
  return rows;
}

}  // namespace

Json calibration_json(const vision::CalibrationResult& result) {
  const vision::CameraCalibration& c = result.calibration;
  const vision::LensModel& lens = c.lens;
  return {
      {"schema", "tribotrack calibration 1"},
      {"width_px", c.width},
      {"height_px", c.height},
      {"mm_per_px", c.mm_per_px},
      {"mm_per_px_sd", c.mm_per_px_sd},
      {"distance_mm", c.distance_mm()},
      {"camera_matrix", Json::array({{lens.fx, 0.0, lens.cx}, {0.0, lens.fy, lens.cy}, {0.0, 0.0, 1.0}})},
      {"distortion", {{"k1", lens.k1}, {"k2", lens.k2}, {"p1", lens.p1}, {"p2", lens.p2}, {"k3", lens.k3}}},
      {"model", result.model},
      {"models_tried", result.tried},
      {"plane",
       {{"rotation", matrix_json(c.plane.rotation)},
        {"translation_mm", {c.plane.translation.x(), c.plane.translation.y(), c.plane.translation.z()}},
        {"homography_from_undistorted_px", matrix_json(vision::plane_homography(c))}}},
      {"rms_px", result.rms_px},
      {"pictures", pictures_json(result.pictures)},
      {"left_out", result.left_out},
      {"covariance_of", result.covariance_of},
      {"covariance", matrix_json(result.covariance)}};
}

namespace {

vision::CameraCalibration calibration_from(const JsonPlace& json) {
  vision::CameraCalibration c;
  c.width = json.at("width_px").integer();
  c.height = json.at("height_px").integer();
  c.mm_per_px = json.at("mm_per_px").number();
  c.mm_per_px_sd = json.at("mm_per_px_sd").number();
  const JsonPlace camera = json.at("camera_matrix");
  c.lens.fx = camera.at(0).at(0).number();
  c.lens.fy = camera.at(1).at(1).number();
  c.lens.cx = camera.at(0).at(2).number();
  c.lens.cy = camera.at(1).at(2).number();
  const JsonPlace d = json.at("distortion");
  c.lens.k1 = d.at("k1").number();
  c.lens.k2 = d.at("k2").number();
  c.lens.p1 = d.at("p1").number();
  c.lens.p2 = d.at("p2").number();
  c.lens.k3 = d.at("k3").number();
  const JsonPlace translation = json.at("plane").at("translation_mm");
  const JsonPlace rotation = json.at("plane").at("rotation");
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    c.plane.translation(row) = translation.at(i).number();
    for (std::size_t j = 0; j < 3; ++j)
      c.plane.rotation(row, static_cast<Eigen::Index>(j)) = rotation.at(i).at(j).number();
  }
  const Eigen::Matrix3d& r = c.plane.rotation;
  constexpr double rounding = 1e-6;
  if (!((r * r.transpose() - Eigen::Matrix3d::Identity()).norm() < rounding))
    rotation.refuse("a rotation, whose rows are of length 1 and at right angles");
  return c;
}

}  // namespace

vision::CameraCalibration read_calibration(const std::filesystem::path& path) {
  const Json json = read_json(path);
  vision::CameraCalibration c;
  try {
    c = calibration_from({json, ""});
  } catch (const WrongContent& error) {
    throw InvalidInput(fmt::format("{}: is no calibration: {}; make one with `tribotrack calibrate`",
                                   path.string(), error.what()));
  }
  if (!(c.lens.fx > 0 && c.lens.fy > 0 && c.mm_per_px > 0 && c.width > 0 && c.height > 0 &&
        c.distance_mm() > 0))
    throw InvalidInput(
        fmt::format("{}: is no calibration: its sizes must be greater than 0; make a new one with "
                    "`tribotrack calibrate`",
                    path.string()));
  return c;
}

}  // namespace tribotrack::apps
