#include "vision/platform_motion/noise_free.h"

#include <algorithm>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace tribotrack::vision {
namespace {

constexpr int kReach = 2;  ///< frequencies either way whose power is averaged: 25
/// Noise alone scatters by a fifth of its mean there: three times that is no noise.
constexpr float kStandsOut = 1.6F;

/// The spectrum is that of a picture that repeats.
cv::Mat mean_over_neighbours(const cv::Mat& power) {
  cv::Mat grown, mean;
  cv::copyMakeBorder(power, grown, kReach, kReach, kReach, kReach, cv::BORDER_WRAP);
  cv::blur(grown, mean, {2 * kReach + 1, 2 * kReach + 1});
  return mean({kReach, kReach, power.cols, power.rows});
}

}  // namespace

Picture noise_free(const Picture& picture, double noise_variance) {
  const auto levels = picture.levels();
  const double mean = std::accumulate(levels.begin(), levels.end(), 0.0) / static_cast<double>(levels.size());
  cv::Mat in(picture.height(), picture.width(), CV_32F);
  std::ranges::transform(levels, in.begin<float>(), [&](float l) { return l - static_cast<float>(mean); });
  cv::Mat spectrum, parts[2], power;
  cv::dft(in, spectrum, cv::DFT_COMPLEX_OUTPUT);
  cv::split(spectrum, parts);
  power = parts[0].mul(parts[0]) + parts[1].mul(parts[1]);
  const cv::Mat smooth = mean_over_neighbours(power);
  const auto noise = static_cast<float>(noise_variance * static_cast<double>(levels.size()));
  for (int y = 0; y < in.rows; ++y)
    for (int x = 0; x < in.cols; ++x) {
      const float p = smooth.at<float>(y, x);
      spectrum.at<cv::Vec2f>(y, x) *= p > kStandsOut * noise ? 1 - noise / p : 0.0F;
    }
  cv::Mat back;
  cv::dft(spectrum, back, cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
  Picture out(picture.width(), picture.height());
  std::ranges::transform(back.begin<float>(), back.end<float>(), out.levels().begin(),
                         [&](float l) { return l + static_cast<float>(mean); });
  return out;
}

}  // namespace tribotrack::vision
