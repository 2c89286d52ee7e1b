#include "vision/platform_motion/coarse_shift.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "vision/kernels/median.h"
#include "vision/platform_motion/noise_free.h"

namespace tribotrack::vision {
namespace {

constexpr int kLargest = 640;  ///< side of a picture, in bins: half a bin stays within a texture's width
constexpr int kBroad = 33;     ///< bins over which light is smooth
constexpr float kUsual =
    3 * static_cast<float>(kNormalMad);  ///< of the median size: what is larger is clipped
constexpr double kFarthest = 0.25;       ///< of the picture's side

}  // namespace

CoarseShift::CoarseShift(const Picture& first, const std::vector<Circle>& hidden, double noise_variance)
    : bin_((std::max(first.width(), first.height()) + kLargest - 1) / kLargest) {
  const cv::Mat levels = texture(first, hidden);
  Picture picture(levels.cols, levels.rows);
  std::copy(levels.begin<float>(), levels.end<float>(), picture.levels().begin());
  const Picture quiet =
      noise_free(picture, Picture(levels.cols, levels.rows, 1), noise_variance / (bin_ * bin_));
  cv::Mat windowed(levels.size(), CV_32F), hann;
  std::ranges::copy(quiet.levels(), windowed.begin<float>());
  // Of one picture only: two windows that stay would draw the shift to zero.
  if (levels.cols > 1 && levels.rows > 1) {
    cv::createHanningWindow(hann, levels.size(), CV_32F);
    windowed = windowed.mul(hann);
  }
  cv::dft(windowed, first_);
}

/// Mean levels of the bins less what is broad, 0 where hidden.
cv::Mat CoarseShift::texture(const Picture& picture, const std::vector<Circle>& hidden) const {
  const int width = picture.width() / bin_, height = picture.height() / bin_;
  cv::Mat levels(height, width, CV_32F, cv::Scalar(0)), there(height, width, CV_32F, cv::Scalar(1));
  const auto share = static_cast<float>(1.0 / (bin_ * bin_));
  for (int y = 0; y < height * bin_; ++y) {
    const auto row = picture.row(y);
    auto* to = levels.ptr<float>(y / bin_);
    for (int x = 0; x < width * bin_; ++x) to[x / bin_] += share * row[static_cast<std::size_t>(x)];
  }
  for (const Circle& c : hidden)
    cv::circle(there, {static_cast<int>(c.x / bin_), static_cast<int>(c.y / bin_)},
               static_cast<int>(c.radius / bin_) + 1, cv::Scalar(0), cv::FILLED);
  levels = levels.mul(there);
  cv::Mat broad, covered;
  cv::blur(levels, broad, {kBroad, kBroad});
  cv::blur(there, covered, {kBroad, kBroad});
  broad /= cv::max(covered, 1e-3F);
  levels -= broad.mul(there);
  std::vector<float> sizes;
  for (auto l = levels.begin<float>(); l != levels.end<float>(); ++l)
    if (*l != 0) sizes.push_back(std::abs(*l));
  const auto usual = static_cast<double>(kUsual * median(sizes));
  return cv::min(cv::max(levels, -usual), usual);
}

Point CoarseShift::of(const Picture& picture, const std::vector<Circle>& hidden) const {
  cv::Mat product, correlation;
  cv::dft(texture(picture, hidden), product);
  cv::mulSpectrums(product, first_, product, 0, true);
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
