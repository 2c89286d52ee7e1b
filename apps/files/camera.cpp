#include "apps/files/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "apps/files/campaign/keys.h"
#include "apps/program/errors.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

namespace {

using Mark = vision::MarkerChoice::Kind;

/// Marks that are named by one word.
constexpr std::pair<const char*, Mark> kMarks[] = {
    {"auto", Mark::find}, {"texture", Mark::texture}, {"none", Mark::none}};

vision::MarkerChoice tag_named(const std::string& name) {
  vision::MarkerChoice marker{Mark::tag, {}};
  const auto colon = name.find(':');
  marker.dictionary = name.substr(0, colon);
  vision::require_tag_family(marker.dictionary);
  if (colon == std::string::npos) return marker;
  const std::string number = name.substr(colon + 1);
  const bool whole = !number.empty() && number.size() < 5 &&
                     std::ranges::all_of(number, [](unsigned char c) { return std::isdigit(c) != 0; });
  if (!whole)
    throw std::invalid_argument(fmt::format("a tag's number is a whole number, not \"{}\"", number));
  marker.id = std::stoi(number);
  return marker;
}

}  // namespace

std::string marker_word(const vision::MarkerChoice& marker) {
  if (marker.kind == Mark::tag)
    return "tag:" + marker.dictionary + (marker.id ? fmt::format(":{}", *marker.id) : "");
  for (const auto& [name, kind] : kMarks)
    if (marker.kind == kind) return name;
  return "texture where the ground moves";
}

namespace fs = std::filesystem;

void check_camera(const StrictTable& table, const CameraSection& camera) {
  if (camera.mm_per_px_sd > 0 && !camera.mm_per_px) table.fail("mm_per_px_sd", "needs mm_per_px");
  if (camera.calibration && camera.mm_per_px)
    table.fail("calibration", "gives the scale, and so does mm_per_px: leave one out");
  if (camera.marker_px && camera.marker.kind == Mark::tag)
    table.fail("marker_px", "and a tag are two marks of the platform; give one of them");
  if (!camera.tag_mm) return;
  if (camera.marker.kind != Mark::tag)
    table.fail("tag_mm", "is the size of a tag; say which: marker = \"tag:apriltag_36h11\"");
  if (camera.mm_per_px || camera.calibration)
    table.fail("tag_mm", fmt::format("gives the scale, and so does {}: leave one out",
                                     camera.mm_per_px ? "mm_per_px" : "calibration"));
}

namespace {

/// `marker`: without marker_px, how the platform's motion is seen.
void read_marker(StrictTable& table, CameraSection& camera, const fs::path&) {
  const auto word = table.text("marker");
  if (!word) return;
  if (word->starts_with("tag:")) {
    try {
      camera.marker = tag_named(word->substr(4));
    } catch (const std::invalid_argument& error) {
      table.fail("marker", fmt::format("names no tag: {}", error.what()));
    }
    return;
  }
  const auto* mark = std::ranges::find(kMarks, *word, &std::pair<const char*, Mark>::first);
  if (mark == std::end(kMarks))
    table.fail("marker", fmt::format("must be {}, not \"{}\"", kMarkerWords, *word));
  camera.marker = {mark->second, {}};
}

Json written_marker(const CameraSection& camera) {
  return marker_word(camera.marker);
}

}  // namespace

const Keys<PartSection>& part_keys() {
  using P = PartSection;
  static const Keys<P> keys = {
      {"name", Kind::text, at<&P::name>, "\"disc\"",
       "where there are several: a [[part]] of its own for each; each gets its own fit"},
      {"disc_px", Kind::circle, at<&P::target>, "[640, 400, 150]",
       "where it lies at first, unless the run says"},
      {"template_px", Kind::rectangle, at<&P::target>, "[100, 40, 41, 41]", "instead of a disc"},
      {"diameter_mm", Kind::above_zero, at<&P::diameter_mm>, "6.0",
       "sets the scale, unless mm_per_px or a calibration does"},
      {"diameter_mm_sd", Kind::sd, at<&P::diameter_sd_mm>, "0.005", "by a caliper"},
      {"chamfer_mm", Kind::not_negative, at<&P::chamfer_mm>, "0.1",
       "width of its chamfer seen from above, 0 for a sharp edge: without it a diameter gives the scale to 1 "
       "to 2 %"},
      {"height_mm", Kind::above_zero, at<&P::height_mm>, "0.8",
       "with working_distance_mm: the part's top is nearer to the camera than the mark"},
      {"height_mm_sd", Kind::sd, at<&P::height_sd_mm>, "0.01"},
  };
  return keys;
}

const Keys<CameraSection>& camera_keys() {
  using C = CameraSection;
  static const Keys<C> keys = {
      {"frame_rate_hz", Kind::above_zero, at<&C::frame_rate_hz>, "1000.0",
       "only where the recording does not give it (see `tribotrack probe VIDEO`)"},
      {"frame_rate_reason", Kind::text, at<&C::frame_rate_reason>, "\"the camera's display\"",
       "how you know it, where the file states the rate of playback", "frame_rate_hz"},
      {"frame_rate_hz_sd", Kind::sd, at<&C::frame_rate_sd_hz>, "0.01"},
      {"mm_per_px", Kind::above_zero, at<&C::mm_per_px>, "0.02", "leave out to scale by the part's diameter"},
      {"tag_mm", Kind::above_zero, at<&C::tag_mm>, "8.0",
       "side of the tag's black square, where `marker` is one: sets the scale"},
      {"tag_mm_sd", Kind::sd, at<&C::tag_mm_sd>, "0.02", "as printed"},
      {"mm_per_px_sd", Kind::not_negative, at<&C::mm_per_px_sd>, "0.00002"},
      {"calibration", Kind::file, at<&C::calibration>, "\"calibration.json\"",
       "by `tribotrack calibrate`, instead of mm_per_px"},
      {"working_distance_mm", Kind::above_zero, at<&C::working_distance_mm>, "100.0",
       "from lens to platform"},
      {"working_distance_mm_sd", Kind::sd, at<&C::working_distance_sd_mm>, "1.0"},
      {"row_time_s", Kind::number, at<&C::row_time_s>, "0.00001",
       "rolling shutter: from one row of the picture to the next one below"},
      {"xi_axis_rad", Kind::angle, at<&C::xi_axis_rad>, "0.0",
       "direction, in the picture, of the platform's displacement when the phase sensor fires"},
      {"xi_axis_rad_sd", Kind::sd, at<&C::xi_axis_sd_rad>, "0.01"},
      {"disc_px", Kind::circle, at<&C::target>, "[640, 400, 150]",
       "x, y, radius in the first frame; leave out to have it found"},
      {"template_px", Kind::rectangle, at<&C::target>, "[100, 40, 41, 41]",
       "instead of a disc: x, y, width, height of a part of any shape in the first frame; needs mm_per_px"},
      {"marker_px", Kind::circle, at<&C::marker_px>, "[200, 180, 24]",
       "a mark fixed to the platform; leave out where there is none"},
      {"marker", Kind::text, Own<C>{read_marker, written_marker}, "\"texture\"",
       "without marker_px: by the platform's own texture (as by itself where that moves); \"auto\": a round "
       "mark, else texture; \"none\"; \"tag:apriltag_36h11:3\": an ArUco or AprilTag tag"},
      {"gate_px", Kind::circle, at<&C::gate_px>, "[30, 30, 6]",
       "an LED that is on while the actuator is: phi and dtau are measured from it"},
  };
  return keys;
}

CameraSection read_camera(StrictTable& table, const fs::path& folder) {
  if (table.has("rehearse"))
    table.fail("rehearse",
               "has left: standard deviations include what the codec may have done; leave the key out, and "
               "for smaller ones film uncompressed or FFV1");
  CameraSection camera;
  read_keys(table, camera_keys(), camera, folder);
  check_camera(table, camera);
  if (camera.calibration && !fs::exists(*camera.calibration))
    table.fail(
        "calibration",
        fmt::format("names {}, which is not there; check its name, or make it with `tribotrack calibrate`",
                    camera.calibration->string()));
  table.finish();
  return camera;
}

bool can_be_chamfer(double chamfer, double diameter) {
  return chamfer >= 0 && 2 * chamfer < diameter;
}

void check_part(const StrictTable& table, const PartSection& part) {
  if (part.chamfer_mm && part.diameter_mm && !can_be_chamfer(*part.chamfer_mm, *part.diameter_mm))
    table.fail("chamfer_mm", "must be less than half of `diameter_mm`");
}

PartSection read_part(StrictTable& table) {
  PartSection part;
  read_keys(table, part_keys(), part);
  check_part(table, part);
  table.finish();
  return part;
}

namespace {

Json matrix_json(const Eigen::Matrix3d& matrix) {
  Json rows = Json::array();
  for (const auto& row : matrix.rowwise()) rows.push_back(std::vector<double>(row.begin(), row.end()));
  return rows;
}

Json pictures_json(const std::vector<vision::PictureResult>& pictures) {
  Json rows = Json::array();
  for (const auto& p : pictures)
    rows.push_back(
        {{"picture", p.name}, {"corners", p.corners}, {"rms_px", p.rms_px}, {"tilt_rad", p.tilt_rad}});
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
      {"focal_sd_px", result.focal_sd_px},
      {"model", result.model},
      {"models_tried", result.tried},
      {"plane",
       {{"rotation", matrix_json(c.plane.rotation)},
        {"translation_mm", {c.plane.translation.x(), c.plane.translation.y(), c.plane.translation.z()}},
        {"homography_from_undistorted_px", matrix_json(vision::plane_homography(c))}}},
      {"rms_px", result.rms_px},
      {"pictures", pictures_json(result.pictures)},
      {"left_out", result.left_out}};
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
    throw InvalidInput("{}: is no calibration: {}; make one with `tribotrack calibrate`", path.string(),
                       error.what());
  }
  if (!(c.lens.fx > 0 && c.lens.fy > 0 && c.mm_per_px > 0 && c.width > 0 && c.height > 0 &&
        c.distance_mm() > 0))
    throw InvalidInput(
        "{}: is no calibration: its sizes must be greater than 0; make a new one with `tribotrack calibrate`",
        path.string());
  return c;
}

}  // namespace tribotrack::apps
