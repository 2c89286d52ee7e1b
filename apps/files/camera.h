// The camera, the part and its mark as files and command lines tell of them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "apps/files/keys.h"
#include "apps/text/json.h"
#include "apps/text/strict_toml.h"
#include "vision/calibration.h"
#include "vision/picture.h"
#include "vision/tracker.h"

namespace tribotrack::apps {

// How the platform's mark is named in campaigns, on the command line and in Python.

/// What may be written, for messages.
inline constexpr const char* kMarkerWords =
    "auto, texture, none or tag:FAMILY[:NUMBER], as tag:apriltag_36h11:3";

/// The word of a mark that is no circle.
std::string marker_word(const vision::MarkerChoice& marker);

// [camera] and [part]: the picture and the part in it, in a campaign and in the file of `track --config`.

struct PartSection {
  std::string name;  ///< empty: the campaign's only one, without a name
  std::optional<double> diameter_mm, height_mm;
  double diameter_sd_mm = 0;  ///< 0: not given
  std::optional<double> height_sd_mm;
  std::optional<double> chamfer_mm;  ///< width of its ring seen from above; 0: a sharp edge
  vision::Target target;             ///< where it lies at first, in every run that does not say
  Digits digits = {};                ///< of what is given
};

/// Whether a part of that diameter can have a chamfer of that width, both in mm.
bool can_be_chamfer(double chamfer, double diameter);

struct CameraSection {
  std::optional<double> frame_rate_hz;
  std::string frame_rate_reason;  ///< how the user knows it
  std::optional<double> mm_per_px;
  double mm_per_px_sd = 0;
  std::optional<std::filesystem::path> calibration;  ///< resolved against the file's folder
  double xi_axis_rad = 0;
  std::optional<double> tag_mm;  ///< side of the tag's black square, where the marker is one: sets the scale
  double tag_mm_sd = 0;
  double row_time_s = 0;  ///< of a rolling shutter: from one row to the next one below
  std::optional<double> working_distance_mm;
  std::optional<double> frame_rate_sd_hz, xi_axis_sd_rad, working_distance_sd_mm;
  vision::Target target;  ///< the part in the first analysed frame
  std::optional<vision::Circle> marker_px, gate_px;
  /// Without marker_px: how the platform's motion is seen.
  vision::MarkerChoice marker = {};
  Digits digits = {};  ///< of what is given
};

/// Both read the whole table and refuse unknown keys. Throw InvalidInput with file, line and column.
PartSection read_part(StrictTable& table);
CameraSection read_camera(StrictTable& table, const std::filesystem::path& folder);

/// What of the keys contradicts each other, in the table that gives them. Throw InvalidInput.
void check_part(const StrictTable& table, const PartSection& part);
void check_camera(const StrictTable& table, const CameraSection& camera);

/// Is it said where the part lies?
inline bool is_given(const vision::Target& target) {
  return target.kind != vision::Target::Kind::find_disc;
}

// calibration.json: what `calibrate` found out about a camera.

/// Camera matrix, distortion, the platform's plane and its homography, scale, table of pictures, covariance.
Json calibration_json(const vision::CalibrationResult& result);

/// What tracking needs of it. Throws InvalidInput naming the file and the key that is missing or wrong.
vision::CameraCalibration read_calibration(const std::filesystem::path& path);

}  // namespace tribotrack::apps
