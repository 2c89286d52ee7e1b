// Pictures as PNG files.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace tribotrack::vision {

/// The bytes of a PNG file (ISO/IEC 15948) of a CV_8UC1, CV_16UC1 or CV_8UC3 (B, G, R) picture, coded for
/// speed: each byte less its neighbour to the left, then runs and Huffman codes. Here, since zlib is all that
/// is needed; OpenCV's imgcodecs brings a hundred libraries. Throws std::invalid_argument on another kind of
/// picture.
std::vector<unsigned char> png_of(const cv::Mat& image);

}  // namespace tribotrack::vision
