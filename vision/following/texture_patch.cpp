#include "vision/following/texture_patch.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr int kSmallest = 24;  ///< px: a smaller window sees too little of a texture a few pixels wide
constexpr int kStep = 4;
constexpr double kSignificant = 6;  ///< sd: the best of thousands of windows is looked for

/// Sums over any rectangle in constant time.
class SumTable {
 public:
  SumTable(int width, int height)
      : width_(width + 1), sums_(static_cast<std::size_t>(width + 1) * (height + 1)) {}
  /// Rows from the top, pixels from the left.
  void add(int x, int y, double value) { at(x + 1, y + 1) = value + at(x, y + 1) + at(x + 1, y) - at(x, y); }
  double over(const Rect& r) const {
    return at(r.x + r.width, r.y + r.height) - at(r.x, r.y + r.height) - at(r.x + r.width, r.y) +
           at(r.x, r.y);
  }

 private:
  double& at(int x, int y) { return sums_[static_cast<std::size_t>(y) * width_ + x]; }
  double at(int x, int y) const { return sums_[static_cast<std::size_t>(y) * width_ + x]; }
  std::size_t width_;
  std::vector<double> sums_;
};

struct Gradients {
  SumTable xx, xy, yy, covered;
};

Gradients gradients_of(const Picture& p, const std::vector<Circle>& covered) {
  Gradients g{
      {p.width(), p.height()}, {p.width(), p.height()}, {p.width(), p.height()}, {p.width(), p.height()}};
  for (int y = 0; y < p.height(); ++y)
    for (int x = 0; x < p.width(); ++x) {
      const bool border = x == 0 || y == 0 || x + 1 == p.width() || y + 1 == p.height();
      const double gx = border ? 0 : 0.5 * (p.at(x + 1, y) - p.at(x - 1, y));
      const double gy = border ? 0 : 0.5 * (p.at(x, y + 1) - p.at(x, y - 1));
      g.xx.add(x, y, gx * gx);
      g.xy.add(x, y, gx * gy);
      g.yy.add(x, y, gy * gy);
      const bool hidden = std::any_of(covered.begin(), covered.end(), [&](const Circle& c) {
        return std::hypot(x - c.x, y - c.y) <= c.radius;
      });
      g.covered.add(x, y, hidden);
    }
  return g;
}

/// Smaller eigenvalue of the sum of grad f grad f^T without the noise's share; 0 where it is not above what
/// noise alone may show. A central difference has variance s^2 / 2, its square one of s^4 / 2, and two pixels
/// along the difference share a level: the sum over n pixels scatters by s^2 sqrt(3 n / 4).
double information(const Gradients& g, const Rect& r, double noise_variance) {
  const double n = static_cast<double>(r.width) * r.height;
  const double of_noise = 0.5 * noise_variance * n;
  const double a = g.xx.over(r) - of_noise, b = g.xy.over(r), c = g.yy.over(r) - of_noise;
  const double smaller = 0.5 * (a + c) - std::hypot(0.5 * (a - c), b);
  return smaller > kSignificant * noise_variance * std::sqrt(0.75 * n) ? smaller : 0;
}

}  // namespace

std::optional<TexturePatch> best_texture_patch(const Picture& first, const TexturePatchSearch& search,
                                               std::string& why_not) {
  const Gradients gradients = gradients_of(first, search.covered);
  const int m = search.margin_px;
  double best = 0;
  bool any = false;
  Rect window;
  for (int side = kSmallest; side <= std::min(first.width(), first.height()) - 2 * m; side += 2 * kStep)
    for (int y = m; y + side + m <= first.height(); y += kStep)
      for (int x = m; x + side + m <= first.width(); x += kStep) {
        const Rect r{x, y, side, side};
        if (gradients.covered.over(r) > 0.5) continue;
        any = true;
        if (const double i = information(gradients, r, search.noise_variance); i > best) {
          best = i;
          window = r;
        }
      }
  if (!any) {
    why_not = "the part's path leaves no window of the platform uncovered";
    return std::nullopt;
  }
  const double limit = best > 0 ? std::sqrt(search.noise_variance / best) : 1e9;
  if (!(limit <= search.worst_limit_px)) {
    const double noise = std::sqrt(search.noise_variance);
    why_not = best > 0
                  ? fmt::format(
                        "the platform's texture would locate it to {:.2g} px a frame only (noise of {:.2f} "
                        "grey levels)",
                        limit, noise)
                  : fmt::format("the platform shows no texture above the noise of {:.2f} grey levels", noise);
    return std::nullopt;
  }
  return TexturePatch{window, limit};
}

}  // namespace tribotrack::vision
