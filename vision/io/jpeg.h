// Grey pictures as JPEG files.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace tribotrack::vision {

/// The bytes of a JPEG file (ITU-T T.81, baseline) of a CV_8UC1 picture; `quality` 1 to 100 as libjpeg has
/// it. Throws std::invalid_argument on another kind of picture.
std::vector<unsigned char> jpeg_of(const cv::Mat& image, int quality);

}  // namespace tribotrack::vision
