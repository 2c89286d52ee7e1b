#include "vision/registration/pattern.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "vision/kernels/median.h"
#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

/// Of the disc's contrast: pixels outside the rim that differ by more from the mean rim profile belong to
/// something else (a neighbour touching the disc, its shadow) and are left out.
constexpr double kForeign = 0.35;

/// Profile at a fractional distance, linear between whole ones.
double profile_at(const std::vector<float>& profile, double rho) {
  const auto last = static_cast<double>(profile.size() - 1);
  rho = std::clamp(rho, 0.0, last);
  const auto k = std::min(static_cast<std::size_t>(rho), profile.size() - 2);
  const double t = rho - static_cast<double>(k);
  return (1 - t) * profile[k] + t * profile[k + 1];
}

/// Median grey level by distance from the centre, whole pixels 0 .. radius + 1.
std::vector<float> radial_profile(const Picture& picture, const Point& centre, double radius) {
  std::vector<std::vector<float>> rings(static_cast<std::size_t>(std::ceil(radius)) + 2);
  const int reach = static_cast<int>(std::ceil(radius)) + 1;
  const int cx = static_cast<int>(std::lround(centre.x));
  const int cy = static_cast<int>(std::lround(centre.y));
  for (int y = std::max(0, cy - reach); y <= std::min(picture.height() - 1, cy + reach); ++y)
    for (int x = std::max(0, cx - reach); x <= std::min(picture.width() - 1, cx + reach); ++x) {
      const auto ring = static_cast<std::size_t>(std::lround(std::hypot(x - centre.x, y - centre.y)));
      if (ring < rings.size()) rings[ring].push_back(picture.at(x, y));
    }
  std::vector<float> profile(rings.size());
  for (std::size_t k = 0; k < rings.size(); ++k)
    profile[k] = !rings[k].empty() ? median(rings[k]) : k > 0 ? profile[k - 1] : 0.0F;
  if (rings[0].empty()) profile[0] = profile[1];
  return profile;
}

}  // namespace

bool Pattern::inside(const Rect& bounds, const Point& at, double margin) const {
  const auto [half_x, half_y] = half();
  return at.x - half_x - margin >= bounds.x - 0.5 && at.y - half_y - margin >= bounds.y - 0.5 &&
         at.x + half_x + margin <= bounds.x + bounds.width - 0.5 &&
         at.y + half_y + margin <= bounds.y + bounds.height - 0.5;
}

bool Pattern::overlaps(const Rect& bounds, const Point& at) const {
  const auto [half_x, half_y] = half();
  return at.x + half_x > bounds.x - 0.5 && at.y + half_y > bounds.y - 0.5 &&
         at.x - half_x < bounds.x + bounds.width - 0.5 && at.y - half_y < bounds.y + bounds.height - 0.5;
}

Pattern disc_pattern(const Picture& first, const Circle& disc, double margin) {
  Pattern pattern;
  pattern.centre = {disc.x, disc.y};
  pattern.radius = disc.radius;
  const double mask = disc.radius + margin;
  const int x0 = std::max(0, static_cast<int>(std::floor(disc.x - mask)));
  const int y0 = std::max(0, static_cast<int>(std::floor(disc.y - mask)));
  const int x1 = std::min(first.width() - 1, static_cast<int>(std::ceil(disc.x + mask)));
  const int y1 = std::min(first.height() - 1, static_cast<int>(std::ceil(disc.y + mask)));
  pattern.window = {x0, y0, x1 - x0 + 1, y1 - y0 + 1};
  pattern.weights = Picture(pattern.window.width, pattern.window.height);
  const std::vector<float> profile = radial_profile(first, pattern.centre, mask + 1);
  const double inner = profile_at(profile, std::max(0.0, disc.radius - 3));
  const double outer = profile_at(profile, disc.radius + 3);
  const double foreign = kForeign * std::abs(inner - outer);
  for (int y = 0; y < pattern.window.height; ++y)
    for (int x = 0; x < pattern.window.width; ++x) {
      const double rho = std::hypot(x + x0 - disc.x, y + y0 - disc.y);
      if (rho > mask) continue;
      const bool outside = rho > disc.radius + 0.5;
      const bool differs = std::abs(first.at(x + x0, y + y0) - profile_at(profile, rho)) > foreign;
      pattern.weights.at(x, y) = outside && differs ? 0.0F : 1.0F;
    }
  return pattern;
}

Pattern rectangle_pattern(const Rect& rectangle) {
  Pattern pattern;
  pattern.window = rectangle;
  pattern.weights = Picture(rectangle.width, rectangle.height, 1);
  pattern.centre = {rectangle.x + 0.5 * (rectangle.width - 1), rectangle.y + 0.5 * (rectangle.height - 1)};
  return pattern;
}

MaskedTemplate search_template(const Picture& first, const Pattern& pattern) {
  const Rect& window = pattern.window;
  MaskedTemplate out{Picture(window.width, window.height), Picture(window.width, window.height)};
  std::vector<float> profile;
  if (pattern.radius > 0) profile = radial_profile(first, pattern.centre, pattern.radius + 4);
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      const double rho = std::hypot(x + window.x - pattern.centre.x, y + window.y - pattern.centre.y);
      if (pattern.radius > 0) {
        out.levels.at(x, y) = static_cast<float>(profile_at(profile, rho));
        out.weights.at(x, y) = rho <= pattern.radius + 3 ? 1.0F : 0.0F;
      } else {
        out.levels.at(x, y) = first.at(x + window.x, y + window.y);
        out.weights.at(x, y) = 1;
      }
    }
  return out;
}

namespace {

using std::numbers::pi;

constexpr double kRim = 2.5;              ///< px inside the rim: its slopes are not texture
constexpr double kNarrow = 1, kWide = 3;  ///< sd of the smoothing, px: a scratch's width, a reflection's
constexpr double kStandsOut = 5;          ///< sd of what noise alone would make
constexpr double kNone = 1e9;

/// Mean of what lies inside the mask, weighted by a Gaussian.
Picture smoothed(const Picture& levels, const Picture& mask, double sd) {
  const int side = 2 * static_cast<int>(std::ceil(3 * sd)) + 1;
  const auto blurred = [&](const cv::Mat& from) {
    cv::Mat to;
    cv::GaussianBlur(from, to, {side, side}, sd, sd, cv::BORDER_CONSTANT);
    return to;
  };
  Picture out(levels.width(), levels.height());
  cv::Mat mean = matrix_of(out);
  cv::divide(blurred(matrix_of(levels).mul(matrix_of(mask))), cv::max(blurred(matrix_of(mask)), 1e-30F),
             mean);
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
