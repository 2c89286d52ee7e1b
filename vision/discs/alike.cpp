#include "vision/discs/alike.h"

#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr double kSeenAsWell = 0.5;  ///< of the score
constexpr double kSameSize = 0.9, kSameContrast = 0.67, kSeen = 0.2;
constexpr double kAboutAsLarge = 0.67;

double ratio(double a, double b) {
  const double low = std::min(a, b), high = std::max(a, b);
  return low > 0 ? low / high : (high < 0 ? high / low : 0);
}

double distance(const Circle& a, const Circle& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

}  // namespace

bool alike(const DiscFit& other, const DiscFit& part) {
  const double size = ratio(other.circle.radius, part.circle.radius);
  if (size > kAsLarge && other.score > kSeenAsWell * part.score) return true;
  return size > kSameSize && ratio(other.contrast, part.contrast) > kSameContrast &&
         other.score > kSeen * part.score;
}

std::vector<Circle> discs_alike(std::span<const DiscFit> found, const DiscFit& part) {
  std::vector<Circle> out{part.circle};
  for (const DiscFit& other : found)
    if (alike(other, part) && std::ranges::none_of(out, [&](const Circle& c) {
          return distance(c, other.circle) < std::max(c.radius, other.circle.radius);
        }))
      out.push_back(other.circle);
  std::ranges::sort(out, {}, &Circle::x);
  return out;
}

const DiscFit* nearest_like(std::span<const DiscFit> found, const Circle& given) {
  const DiscFit* best = nullptr;
  for (const DiscFit& f : found)
    if (ratio(f.circle.radius, given.radius) > kAboutAsLarge &&
        (!best || distance(f.circle, given) < distance(best->circle, given)))
      best = &f;
  return best;
}

}  // namespace tribotrack::vision
