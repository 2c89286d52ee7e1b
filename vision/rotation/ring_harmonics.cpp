#include "vision/rotation/ring_harmonics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

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
  weights_ = Eigen::ArrayXXf::Zero(angles_ / 2, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    for (Eigen::Index m = 2; m < weights_.rows(); ++m) {
      const double wave = 2 * pi * rings_(k) / static_cast<double>(m);
      if (wave >= kShortest && wave <= kLongest) weights_(m, k) = static_cast<float>(rings_(k));
    }
    for (int j = 0; j < angles_; ++j) {
      offset_x_.push_back(static_cast<float>(rings_(k) * std::cos(2 * pi * j / angles_)));
      offset_y_.push_back(static_cast<float>(-rings_(k) * std::sin(2 * pi * j / angles_)));
    }
  }
}

double RingHarmonics::reach() const {
  return radius_ + kBorder * reduction_;
}

Harmonics RingHarmonics::of(const Picture& window, const Point& centre) {
  double x = centre.x, y = centre.y;
  const Picture* picture = &window;
  if (reduction_ > 1) {
    const int width = window.width() / reduction_, height = window.height() / reduction_;
    if (reduced_.width() != width || reduced_.height() != height) reduced_ = Picture(width, height);
    const cv::Mat from(window.height(), window.width(), CV_32F, const_cast<float*>(window.levels().data()));
    cv::Mat to(height, width, CV_32F, reduced_.levels().data());
    cv::resize(from(cv::Rect(0, 0, width * reduction_, height * reduction_)), to, {width, height}, 0, 0,
               cv::INTER_AREA);
    picture = &reduced_;
    x = (x + 0.5) / reduction_ - 0.5;
    y = (y + 0.5) / reduction_ - 0.5;
  }
  const QuinticSpline spline(*picture);
  const std::size_t count = offset_x_.size();
  for (auto* v : {&x_, &y_, &levels_, &transformed_}) v->resize(count);
  const auto centre_x = static_cast<float>(x), centre_y = static_cast<float>(y);
  for (std::size_t k = 0; k < count; ++k) {
    x_[k] = centre_x + offset_x_[k];
    y_[k] = centre_y + offset_y_[k];
  }
  spline.sample_places(x_, y_, levels_.data(), nullptr, nullptr);
  const auto rings = static_cast<int>(rings_.size());
  cv::Mat packed(rings, angles_, CV_32F, transformed_.data());  // Re 0, Re 1, Im 1, Re 2, ...
  cv::dft(cv::Mat(rings, angles_, CV_32F, levels_.data()), packed, cv::DFT_ROWS);
  Harmonics out{Eigen::ArrayXXf(angles_ / 2, rings), Eigen::ArrayXXf(angles_ / 2, rings)};
  const float share = 1 / static_cast<float>(angles_);
  for (int k = 0; k < rings; ++k) {
    const float* row = packed.ptr<float>(k);
    float *re = out.re.col(k).data(), *im = out.im.col(k).data();
    re[0] = share * row[0];
    im[0] = 0;
    for (int m = 1; m < angles_ / 2; ++m) {
      re[m] = share * row[2 * m - 1];
      im[m] = share * row[2 * m];
    }
  }
  return out;
}

}  // namespace tribotrack::vision
