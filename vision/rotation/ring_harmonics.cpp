#include "vision/rotation/ring_harmonics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "vision/kernels/bspline.h"

namespace tribotrack::vision {
namespace {

using std::numbers::pi;

/// Px: a disc is reduced to between this and twice this radius. Its rotation is then known far better than
/// its position whatever it shows, so that nothing is gained by more pixels.
constexpr double kRadius = 32;
constexpr double kInnermost = 2;                       ///< px: rings within hold hardly a harmonic
constexpr double kRimBlurs = 2.5, kLeastMargin = 1.5;  ///< of the rim: blurs, px
constexpr double kLongest = 40;   ///< px: longer waves are reflections and shading as much as texture
constexpr double kShortest = pi;  ///< px: just longer than two pixels, which is all that a picture resolves
constexpr int kBorder = 8;        ///< px for the spline

}  // namespace

RingHarmonics::RingHarmonics(double radius, double blur)
    : reduction_(std::max(1, static_cast<int>(radius / kRadius))), radius_(radius) {
  const double outermost = (radius - std::max(kLeastMargin, kRimBlurs * blur)) / reduction_;
  const int count = static_cast<int>(std::floor(outermost - kInnermost)) + 1;
  if (count < 2) return;
  rings_ = Eigen::ArrayXd::LinSpaced(count, kInnermost, kInnermost + count - 1);
  for (angles_ = 16; angles_ < 2 * 2 * pi * outermost / kShortest;) angles_ *= 2;
  weights_ = Eigen::ArrayXXd::Zero(count, angles_ / 2);
  for (Eigen::Index k = 0; k < count; ++k)
    for (Eigen::Index m = 2; m < weights_.cols(); ++m) {
      const double wave = 2 * pi * rings_(k) / static_cast<double>(m);
      if (wave >= kShortest && wave <= kLongest) weights_(k, m) = rings_(k);
    }
}

double RingHarmonics::reach() const {
  return radius_ + kBorder * reduction_;
}

Harmonics RingHarmonics::of(const Picture& window, const Point& centre) const {
  Picture reduced;
  double x = centre.x, y = centre.y;
  const Picture* picture = &window;
  if (reduction_ > 1) {
    const int width = window.width() / reduction_, height = window.height() / reduction_;
    reduced = Picture(width, height);
    const cv::Mat from(window.height(), window.width(), CV_32F, const_cast<float*>(window.levels().data()));
    cv::Mat to(height, width, CV_32F, reduced.levels().data());
    cv::resize(from(cv::Rect(0, 0, width * reduction_, height * reduction_)), to, {width, height}, 0, 0,
               cv::INTER_AREA);
    picture = &reduced;
    x = (x + 0.5) / reduction_ - 0.5;
    y = (y + 0.5) / reduction_ - 0.5;
  }
  const QuinticSpline spline(*picture);
  const auto count = static_cast<std::size_t>(rings_.size() * angles_);
  std::vector<float> px(count), py(count);
  cv::Mat levels(static_cast<int>(rings_.size()), angles_, CV_32F);
  for (int j = 0; j < angles_; ++j) {
    const double c = std::cos(2 * pi * j / angles_), s = std::sin(2 * pi * j / angles_);
    for (Eigen::Index k = 0; k < rings_.size(); ++k) {
      const auto place = static_cast<std::size_t>(k * angles_ + j);
      px[place] = static_cast<float>(x + rings_(k) * c);
      py[place] = static_cast<float>(y - rings_(k) * s);
    }
  }
  spline.sample_places(px, py, levels.ptr<float>(), nullptr, nullptr);
  cv::Mat transformed;
  cv::dft(levels, transformed, cv::DFT_ROWS | cv::DFT_COMPLEX_OUTPUT);
  Harmonics out(rings_.size(), angles_ / 2);
  for (int k = 0; k < transformed.rows; ++k)
    for (int m = 0; m < angles_ / 2; ++m) {
      const auto& value = transformed.at<cv::Vec2f>(k, m);
      out(k, m) = std::complex<double>(value[0], value[1]) / static_cast<double>(angles_);
    }
  return out;
}

}  // namespace tribotrack::vision
