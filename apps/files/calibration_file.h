// calibration.json: what `calibrate` found out about a camera.
#pragma once

#include <filesystem>

#include "apps/text/json.h"
#include "vision/calibration.h"

namespace tribotrack::apps {

/// Camera matrix, distortion, the platform's plane and its homography, scale, table of pictures, covariance.
Json calibration_json(const vision::CalibrationResult& result);

/// What tracking needs of it. Throws InvalidInput naming the file and the key that is missing or wrong.
vision::CameraCalibration read_calibration(const std::filesystem::path& path);

}  // namespace tribotrack::apps
