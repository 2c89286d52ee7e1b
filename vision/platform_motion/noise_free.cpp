#include "vision/platform_motion/noise_free.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace tribotrack::vision {
namespace {

constexpr int kBroad = 33;    ///< px over which light is smooth
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

/// A header over the picture's own levels, which stay.
cv::Mat matrix_of(const Picture& p) {
  return {p.height(), p.width(), CV_32F, const_cast<float*>(p.levels().data())};
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
