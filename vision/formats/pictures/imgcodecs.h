// OpenCV's reading and writing of picture files. Its library, with GDAL behind it, is loaded when the first
// of these is called (vision/io/shared_library.h). PNG is written without it (vision/io/png.h).
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace tribotrack::vision {

/// As cv::imread and cv::imreadmulti with IMREAD_UNCHANGED; all throw InputError where the library is not
/// installed.
cv::Mat read_picture(const std::string& file);
std::vector<cv::Mat> read_pages(const std::string& file, int first, int count);
/// One page, not compressed.
std::vector<unsigned char> tiff_of(const cv::Mat& image);

}  // namespace tribotrack::vision
