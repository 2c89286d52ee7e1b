#include "vision/libraries.h"

#include <opencv2/core/version.hpp>

#include "vision/formats/libav/library.h"
#include "vision/formats/pictures/imgcodecs.h"
#include "vision/picture.h"

namespace tribotrack::vision {
namespace {

/// Why it fails; empty where it does not.
template <class Try>
std::string failure_of(bool load, const Try& attempt) {
  if (!load) return "";
  try {
    attempt();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

std::vector<LibraryState> libraries(bool load) {
  return {
      {"OpenCV", CV_VERSION, "calibration boards, drawing", ""},
      {"OpenCV imgcodecs", CV_VERSION, "TIFF and other picture files",
       failure_of(load, [] { tiff_of(cv::Mat(1, 1, CV_8U, cv::Scalar(0))); })},
      {"libavformat", AV_STRINGIFY(LIBAVFORMAT_VERSION), "video files", failure_of(load, [] { libav(); })},
      {"libavcodec", AV_STRINGIFY(LIBAVCODEC_VERSION), "video files", ""}};
}

}  // namespace tribotrack::vision
