#include "vision/platform_motion/motion.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <span>

#include "vision/kernels/median.h"
#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

constexpr int kLargest = 640;  ///< side of a picture, in bins: half a bin stays within a texture's width
constexpr int kBroad = 33;     ///< bins or px over which light is smooth
constexpr float kUsual =
    3 * static_cast<float>(kNormalMad);  ///< of the median size: what is larger is clipped
constexpr double kFarthest = 0.25;       ///< of the picture's side

/// Where nothing is known nearby: as far away as needed.
cv::Mat broad_part(const cv::Mat& levels, const cv::Mat& known) {
  cv::Mat sum, count;
  cv::blur(levels.mul(known), sum, {kBroad, kBroad});
  cv::blur(known, count, {kBroad, kBroad});
  const double share = cv::mean(known)[0];
  const double mean = share > 0 ? cv::mean(levels.mul(known))[0] / share : 0;
  // A trace of the mean of all decides where there is nothing else.
  constexpr double kTrace = 1e-3;
  return (sum + kTrace * mean) / (count + kTrace);
}

}  // namespace

CoarseShift::CoarseShift(const Picture& first, const std::vector<Circle>& hidden, double noise_variance)
    : bin_((std::max(first.width(), first.height()) + kLargest - 1) / kLargest) {
  const cv::Mat levels = texture(first, hidden);
  Picture picture(levels.cols, levels.rows);
  levels.copyTo(matrix_of(picture));
  const Picture quiet =
      noise_free(picture, Picture(levels.cols, levels.rows, 1), noise_variance / (bin_ * bin_));
  cv::Mat windowed = matrix_of(quiet).clone(), hann;
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
  cv::Mat levels, there(height, width, CV_32F, cv::Scalar(1));
  cv::resize(matrix_of(picture)({0, 0, width * bin_, height * bin_}), levels, {width, height}, 0, 0,
             cv::INTER_AREA);
  for (const Circle& c : hidden)
    cv::circle(there, {static_cast<int>(c.x / bin_), static_cast<int>(c.y / bin_)},
               static_cast<int>(c.radius / bin_) + 1, cv::Scalar(0), cv::FILLED);
  levels = (levels - broad_part(levels, there)).mul(there);
  std::vector<float> sizes;
  for (int y = 0; y < height; ++y)
    for (const float level : std::span(levels.ptr<float>(y), static_cast<std::size_t>(width)))
      if (level != 0) sizes.push_back(std::abs(level));
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
  float most = at(0, 0);
  for (int dy = -reach_y; dy <= reach_y; ++dy)
    for (int dx = -reach_x; dx <= reach_x; ++dx)
      if (const float here = at(dx, dy); here > most) most = here, best_x = dx, best_y = dy;
  const auto vertex = [](float before, float here, float after) {
    const float curve = before - 2 * here + after;
    return curve < 0 ? std::clamp(0.5 * (before - after) / curve, -0.5, 0.5) : 0.0;
  };
  return {bin_ * (best_x + vertex(at(best_x - 1, best_y), most, at(best_x + 1, best_y))),
          bin_ * (best_y + vertex(at(best_x, best_y - 1), most, at(best_x, best_y + 1)))};
}

namespace {

constexpr int kFillings = 8;  ///< of what is not known
constexpr int kReach = 2;     ///< frequencies either way whose power is averaged: 25
/// Noise alone scatters by a fifth of its mean there: three times that is no noise.
constexpr float kStandsOut = 1.6F;

/// The spectrum is that of a picture that repeats.
cv::Mat mean_over_neighbours(const cv::Mat& power) {
  cv::Mat grown, mean;
  cv::copyMakeBorder(power, grown, kReach, kReach, kReach, kReach, cv::BORDER_WRAP);
  cv::blur(grown, mean, {2 * kReach + 1, 2 * kReach + 1});
  return mean({kReach, kReach, power.cols, power.rows});
}

cv::Mat filtered(const cv::Mat& levels, double noise_variance) {
  cv::Mat spectrum, parts[2], back;
  cv::dft(levels, spectrum, cv::DFT_COMPLEX_OUTPUT);
  cv::split(spectrum, parts);
  const cv::Mat power = mean_over_neighbours(parts[0].mul(parts[0]) + parts[1].mul(parts[1]));
  const auto noise = static_cast<float>(noise_variance * static_cast<double>(levels.total()));
  for (int y = 0; y < levels.rows; ++y)
    for (int x = 0; x < levels.cols; ++x) {
      const float p = power.at<float>(y, x);
      spectrum.at<cv::Vec2f>(y, x) *= p > kStandsOut * noise ? 1 - noise / p : 0.0F;
    }
  cv::dft(spectrum, back, cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
  return back;
}

}  // namespace

Picture noise_free(const Picture& picture, const Picture& known, double noise_variance,
                   const Picture* before) {
  cv::Mat there;
  cv::threshold(matrix_of(known), there, 0, 1, cv::THRESH_BINARY);
  const cv::Mat broad = broad_part(matrix_of(picture), there);
  const cv::Mat texture = (matrix_of(picture) - broad).mul(there);
  cv::Mat filled = texture.clone(), quiet;
  if (before) filled = texture + (matrix_of(*before) - broad).mul(1 - there);
  for (int k = 0; k <= kFillings; ++k) {
    quiet = filtered(filled, noise_variance);
    filled = texture + quiet.mul(1 - there);
  }
  Picture out(picture.width(), picture.height());
  cv::Mat(quiet + broad).copyTo(matrix_of(out));
  return out;
}

}  // namespace tribotrack::vision
