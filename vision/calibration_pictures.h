// Pictures for a calibration from files, folders, patterns and videos.
#pragma once

#include <filesystem>
#include <vector>

#include "vision/calibration_fit.h"

namespace tribotrack::vision {

/// All pictures of these inputs, of a video or folder at most `most`, evenly spread; none that equals
/// `plane`. Throws InputError.
std::vector<CalibrationPicture> calibration_pictures(const std::vector<std::filesystem::path>& inputs,
                                                     const CalibrationPicture& plane, int most = 40);

/// A single picture (of a folder or a video the first).
CalibrationPicture calibration_picture(const std::filesystem::path& input);

}  // namespace tribotrack::vision
