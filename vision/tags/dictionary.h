// The families of square tags that OpenCV knows: ArUco and AprilTag.
#pragma once

#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>
#include <string>

#include "vision/picture.h"

namespace tribotrack::vision {

/// By its name, "4x4_50" .. "7x7_1000", "original", "apriltag_16h5", "apriltag_25h9", "apriltag_36h10" or
/// "apriltag_36h11". Throws std::invalid_argument naming them.
cv::Ptr<cv::aruco::Dictionary> tag_dictionary(const std::string& name);

/// 8 bits, the darkest and the brightest percent at the ends: detection wants them, accuracy does not suffer.
cv::Mat to_8_bit(const Picture& picture);

}  // namespace tribotrack::vision
