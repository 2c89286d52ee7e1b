#include "vision/registration/rotation_visibility.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace tribotrack::vision {
namespace {

using std::numbers::pi;

constexpr double kRim = 2.5;              ///< px inside the rim: its slopes are not texture
constexpr double kNarrow = 1, kWide = 3;  ///< sd of the smoothing, px: a scratch's width, a reflection's
constexpr double kStandsOut = 5;          ///< sd of what noise alone would make
constexpr double kNone = 1e9;

/// Mean of what lies inside the mask, weighted by a Gaussian.
Picture smoothed(const Picture& levels, const Picture& mask, double sd) {
  const auto as_mat = [](const Picture& p) {
    return cv::Mat(p.height(), p.width(), CV_32F, const_cast<float*>(p.levels().data()));
  };
  const int side = 2 * static_cast<int>(std::ceil(3 * sd)) + 1;
  const auto blurred = [&](const cv::Mat& from) {
    cv::Mat to;
    cv::GaussianBlur(from, to, {side, side}, sd, sd, cv::BORDER_CONSTANT);
    return to;
  };
  Picture out(levels.width(), levels.height());
  cv::Mat mean = as_mat(out);
  cv::divide(blurred(as_mat(levels).mul(as_mat(mask))), cv::max(blurred(as_mat(mask)), 1e-30F), mean);
  return out;
}

/// What is the same all round, a blurred rim above all, does not turn: levels less the mean of their ring,
/// between rings by proportion.
Picture without_rings(const Picture& levels, const Picture& inside, double left, double top) {
  const auto reach = static_cast<std::size_t>(std::hypot(levels.width(), levels.height())) + 3;
  std::vector<double> sum(reach, 0), weight(reach, 0);
  const auto each = [&](const auto& act) {
    for (int y = 0; y < levels.height(); ++y)
      for (int x = 0; x < levels.width(); ++x) {
        if (inside.at(x, y) == 0) continue;
        const double rho = std::hypot(left + x, top + y);
        const auto ring = static_cast<std::size_t>(rho);
        act(x, y, ring, rho - static_cast<double>(ring));
      }
  };
  each([&](int x, int y, std::size_t ring, double part) {
    for (const std::size_t k : {ring, ring + 1}) {
      const double share = k == ring ? 1 - part : part;
      sum[k] += share * static_cast<double>(levels.at(x, y));
      weight[k] += share;
    }
  });
  Picture out(levels.width(), levels.height());
  each([&](int x, int y, std::size_t ring, double part) {
    const auto mean = [&](std::size_t k) { return weight[k] > 0 ? sum[k] / weight[k] : 0; };
    out.at(x, y) = levels.at(x, y) - static_cast<float>((1 - part) * mean(ring) + part * mean(ring + 1));
  });
  return out;
}

/// Covariance of unit white noise smoothed by a and by b, r px apart.
double covariance(double a, double b, double r) {
  const double square = a * a + b * b;
  return std::exp(-0.5 * r * r / square) / (2 * pi * square);
}

/// Variance of the difference of two pixels' levels, two px apart, halved: a slope.
double slope_variance() {
  const auto at = [](double r) {
    return covariance(kNarrow, kNarrow, r) + covariance(kWide, kWide, r) - 2 * covariance(kNarrow, kWide, r);
  };
  return 0.5 * (at(0) - at(2));
}

}  // namespace

double rotation_limit(const Picture& levels, const Pattern& pattern, double noise_variance) {
  const int width = levels.width(), height = levels.height();
  const double left = pattern.window.x - pattern.centre.x, top = pattern.window.y - pattern.centre.y;
  Picture inside(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      inside.at(x, y) = pattern.weights.at(x, y) > 0 &&
                                (pattern.radius <= 0 || std::hypot(left + x, top + y) < pattern.radius - kRim)
                            ? 1.0F
                            : 0.0F;
  const Picture texture = pattern.radius > 0 ? without_rings(levels, inside, left, top) : levels;
  Picture band = smoothed(texture, inside, kNarrow);
  const Picture wide = smoothed(texture, inside, kWide);
  for (std::size_t k = 0; k < band.levels().size(); ++k) band.levels()[k] -= wide.levels()[k];

  double information = 0, of_noise = 0, count = 0;
  const double noise = noise_variance * slope_variance();
  for (int y = 1; y + 1 < height; ++y)
    for (int x = 1; x + 1 < width; ++x) {
      if (inside.at(x - 1, y) * inside.at(x + 1, y) * inside.at(x, y - 1) * inside.at(x, y + 1) == 0)
        continue;
      const double u = left + x, v = top + y;
      const double slope_x = 0.5 * (static_cast<double>(band.at(x + 1, y)) - band.at(x - 1, y));
      const double slope_y = 0.5 * (static_cast<double>(band.at(x, y + 1)) - band.at(x, y - 1));
      information += std::pow(u * slope_y - v * slope_x, 2);
      of_noise += noise * (u * u + v * v);
      ++count;
    }
  // Smoothed noise has few slopes of its own: their squares scatter.
  const double scatter = std::sqrt(2 * 4 * pi * kNarrow * kNarrow / std::max(1.0, count));
  information -= of_noise;
  return information > kStandsOut * scatter * of_noise ? std::sqrt(noise_variance / information) : kNone;
}

}  // namespace tribotrack::vision
