#include "vision/tags/dictionary.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

using cv::aruco::Dictionary;

/// As OpenCV before 4.7 and from 4.7 on hands a dictionary out.
[[maybe_unused]] cv::Ptr<Dictionary> shared(const cv::Ptr<Dictionary>& dictionary) {
  return dictionary;
}
[[maybe_unused]] cv::Ptr<Dictionary> shared(const Dictionary& dictionary) {
  return cv::makePtr<Dictionary>(dictionary);
}

}  // namespace

cv::Ptr<cv::aruco::Dictionary> tag_dictionary(const std::string& name) {
  static const std::array<const char*, 21> names = {
      "4x4_50",        "4x4_100",        "4x4_250",       "4x4_1000", "5x5_50",   "5x5_100",
      "5x5_250",       "5x5_1000",       "6x6_50",        "6x6_100",  "6x6_250",  "6x6_1000",
      "7x7_50",        "7x7_100",        "7x7_250",       "7x7_1000", "original", "apriltag_16h5",
      "apriltag_25h9", "apriltag_36h10", "apriltag_36h11"};
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw std::invalid_argument(
        "dictionary must be one of 4x4_50, 4x4_100, ... 7x7_1000, original, apriltag_16h5, apriltag_25h9, "
        "apriltag_36h10, apriltag_36h11, not " +
        name);
  return shared(cv::aruco::getPredefinedDictionary(static_cast<int>(found - names.begin())));
}

void require_tag_family(const std::string& dictionary) {
  tag_dictionary(dictionary);
}

cv::Mat to_8_bit(const Picture& picture) {
  const cv::Mat levels(picture.height(), picture.width(), CV_32F,
                       const_cast<float*>(picture.levels().data()));
  std::vector<float> sorted(picture.levels().begin(), picture.levels().end());
  const auto rank = [&](double share) {
    const auto at =
        sorted.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), at, sorted.end());
    return static_cast<double>(*at);
  };
  const double low = rank(0.01);
  const double high = std::max(low + 1, rank(0.99));
  cv::Mat out;
  levels.convertTo(out, CV_8U, 240 / (high - low), 8 - 240 * low / (high - low));
  return out;
}

}  // namespace tribotrack::vision
