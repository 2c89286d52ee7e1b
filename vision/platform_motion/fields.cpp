#include "vision/platform_motion/fields.h"

#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr int kField = 128;

bool in_any(const std::vector<Circle>& circles, int x, int y) {
  return std::ranges::any_of(circles,
                             [&](const Circle& c) { return std::hypot(x - c.x, y - c.y) <= c.radius + 1; });
}

/// A central difference of white noise has half its variance.
double information(const Picture& p, const Rect& r, std::vector<Circle> hidden, double noise_variance) {
  std::erase_if(hidden, [&](const Circle& c) {
    return c.x + c.radius + 1 < r.x || c.x - c.radius - 1 > r.x + r.width || c.y + c.radius + 1 < r.y ||
           c.y - c.radius - 1 > r.y + r.height;
  });
  double xx = 0, xy = 0, yy = 0, n = 0;
  for (int y = std::max(1, r.y); y < std::min(p.height() - 1, r.y + r.height); ++y)
    for (int x = std::max(1, r.x); x < std::min(p.width() - 1, r.x + r.width); ++x) {
      if (!hidden.empty() && in_any(hidden, x, y)) continue;
      ++n;
      const double gx = 0.5 * (p.at(x + 1, y) - p.at(x - 1, y));
      const double gy = 0.5 * (p.at(x, y + 1) - p.at(x, y - 1));
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
    }
  const double smaller = 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy);
  return smaller - 0.5 * noise_variance * n;
}

}  // namespace

std::vector<Rect> ground_fields(const Picture& first, const std::vector<Circle>& hidden,
                                double noise_variance, int most_pixels) {
  const Rect whole{0, 0, first.width(), first.height()};
  if (whole.width * whole.height <= most_pixels) return {whole};
  std::vector<std::pair<double, Rect>> fields;
  for (int y = 0; y < whole.height; y += kField)
    for (int x = 0; x < whole.width; x += kField) {
      const Rect r{x, y, std::min(kField, whole.width - x), std::min(kField, whole.height - y)};
      fields.emplace_back(information(first, r, hidden, noise_variance), r);
    }
  std::ranges::stable_sort(fields, std::greater<>(), &std::pair<double, Rect>::first);
  std::vector<Rect> chosen;
  int pixels = 0;
  for (const auto& [information, r] : fields) {
    if (pixels + r.width * r.height > most_pixels) break;
    pixels += r.width * r.height;
    chosen.push_back(r);
  }
  return chosen;
}

}  // namespace tribotrack::vision
