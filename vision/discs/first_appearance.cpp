#include "vision/discs/first_appearance.h"

#include <algorithm>
#include <cmath>

#include "vision/io/levels.h"

namespace tribotrack::vision {
namespace {

constexpr std::int64_t kLooks = 100;  ///< whole frames searched on the way, at most
constexpr double kMargin = 8;         ///< px around the disc that the rim's fit sees

bool nearly_whole(const DiscFit& fit) {
  return fit.coverage >= DiscSearch{}.min_coverage;
}

/// As clear as a disc found without a given place.
bool clear(const DiscFit& fit) {
  const DiscSearch usual;
  return nearly_whole(fit) && std::abs(fit.contrast) >= usual.min_clarity * fit.residual_rms &&
         fit.blur <= usual.max_blur_share * fit.circle.radius;
}

/// A part that comes in over the edge is taken for the template once all its surroundings are seen.
bool has_room(const Circle& c, const Rect& all) {
  const double reach = c.radius + kMargin;
  return c.x >= reach && c.y >= reach && c.x + reach < all.width && c.y + reach < all.height;
}

}  // namespace

std::optional<std::int64_t> arrival_at(FrameSource& source, std::int64_t first, std::int64_t last,
                                       const Circle& place, double capture) {
  const Rect window = window_about(
      {place.x, place.y}, place.radius + capture + std::max(kMargin, 0.2 * place.radius), source.bounds());
  Picture picture;
  for (std::int64_t index = first; index <= last; ++index) {
    source.read(index, window, picture);
    const auto fit = fit_disc(picture, {place.x - window.x, place.y - window.y, place.radius}, capture);
    if (fit && (index == first ? nearly_whole(*fit) : clear(*fit))) return index;
  }
  return std::nullopt;
}

std::optional<std::int64_t> arrival_anywhere(FrameSource& source, std::int64_t first, std::int64_t last,
                                             const DiscSearch& search) {
  Picture picture;
  const auto seen = [&](std::int64_t index) {
    source.read(index, source.bounds(), picture);
    if (index == first) return shows_disc(picture, search);
    const auto found = find_discs(picture, search, 1);
    return !found.empty() && has_room(found.front().circle, source.bounds());
  };
  const std::int64_t step = std::max<std::int64_t>(1, (last - first) / kLooks);
  std::int64_t without = first;
  if (seen(first)) return first;
  for (std::int64_t with = first + step; without < last; with = std::min(with + step, last)) {
    if (!seen(with)) {
      without = with;
      continue;
    }
    while (with - without > 1) {
      const std::int64_t middle = without + (with - without) / 2;
      (seen(middle) ? with : without) = middle;
    }
    return with;
  }
  return std::nullopt;
}

}  // namespace tribotrack::vision
