#include "vision/platform_motion/coarse_shift.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace tribotrack::vision {
namespace {

constexpr int kLargest = 512;       ///< side of a picture, in bins: half a bin stays within a texture's width
constexpr int kBroad = 33;          ///< bins over which light is smooth
constexpr double kFarthest = 0.25;  ///< of the picture's side

}  // namespace

CoarseShift::CoarseShift(const Picture& first, const std::vector<Circle>& hidden)
    : bin_((std::max(first.width(), first.height()) + kLargest - 1) / kLargest) {
  const cv::Size size{first.width() / bin_, first.height() / bin_};
  if (size.width > 1 && size.height > 1) cv::createHanningWindow(hann_, size, CV_32F);
  first_ = spectrum(first, hidden);
}

cv::Mat CoarseShift::spectrum(const Picture& picture, const std::vector<Circle>& hidden) const {
  const int width = picture.width() / bin_, height = picture.height() / bin_;
  cv::Mat levels(height, width, CV_32F, cv::Scalar(0)), there(height, width, CV_32F, cv::Scalar(1));
  for (int y = 0; y < height * bin_; ++y) {
    const auto row = picture.row(y);
    auto* to = levels.ptr<float>(y / bin_);
    for (int x = 0; x < width * bin_; ++x) to[x / bin_] += row[static_cast<std::size_t>(x)];
  }
  for (const Circle& c : hidden)
    cv::circle(there, {static_cast<int>(c.x / bin_), static_cast<int>(c.y / bin_)},
               static_cast<int>(c.radius / bin_) + 1, cv::Scalar(0), cv::FILLED);
  levels = levels.mul(there);
  cv::Mat broad, share;
  cv::blur(levels, broad, {kBroad, kBroad});
  cv::blur(there, share, {kBroad, kBroad});
  broad /= cv::max(share, 1e-3F);
  levels = (levels - broad.mul(there)).mul(hann_);
  cv::Mat out;
  cv::dft(levels, out);
  return out;
}

Point CoarseShift::of(const Picture& picture, const std::vector<Circle>& hidden) const {
  cv::Mat product, correlation;
  cv::mulSpectrums(spectrum(picture, hidden), first_, product, 0, true);
  cv::dft(product, correlation, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT);
  const int reach_x = static_cast<int>(kFarthest * correlation.cols),
            reach_y = static_cast<int>(kFarthest * correlation.rows);
  const auto at = [&](int dx, int dy) {
    return correlation.at<float>((dy + correlation.rows) % correlation.rows,
                                 (dx + correlation.cols) % correlation.cols);
  };
  int best_x = 0, best_y = 0;
  for (int dy = -reach_y; dy <= reach_y; ++dy)
    for (int dx = -reach_x; dx <= reach_x; ++dx)
      if (at(dx, dy) > at(best_x, best_y)) best_x = dx, best_y = dy;
  const auto vertex = [](float before, float here, float after) {
    const float curve = before - 2 * here + after;
    return curve < 0 ? std::clamp(0.5 * (before - after) / curve, -0.5, 0.5) : 0.0;
  };
  const float here = at(best_x, best_y);
  return {bin_ * (best_x + vertex(at(best_x - 1, best_y), here, at(best_x + 1, best_y))),
          bin_ * (best_y + vertex(at(best_x, best_y - 1), here, at(best_x, best_y + 1)))};
}

}  // namespace tribotrack::vision
