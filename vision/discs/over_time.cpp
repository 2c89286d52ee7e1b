// Discs over the frames: the first appearance of the part, and its rest.
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "vision/discs/disc_detection.h"
#include "vision/discs/first_appearance.h"
#include "vision/io/levels.h"
#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr std::int64_t kLooks = 100;  ///< whole frames searched on the way, at most
constexpr double kMargin = 8;         ///< px around the disc that the rim's fit sees
constexpr double kLeastContrast = 4;  ///< grey levels
constexpr double kClick = 2;          ///< px that the radius of a click may be off

bool nearly_whole(const DiscFit& fit) {
  return fit.coverage >= DiscSearch{}.min_coverage;
}

/// As clear as a disc found without a given place.
bool clear(const DiscFit& fit) {
  const DiscSearch usual;
  return nearly_whole(fit) && std::abs(fit.contrast) >= usual.min_clarity * fit.residual_rms &&
         fit.blur <= usual.max_blur_share * fit.circle.radius;
}

/// Of about that radius, and more than what rounding or a coder leaves of an even ground, noiseless as it is.
bool may_be(const DiscFit& fit, double radius) {
  return std::abs(fit.circle.radius - radius) < std::max(kClick, radius / 3) &&
         std::abs(fit.contrast) >= kLeastContrast;
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
    if (fit && may_be(*fit, place.radius) && (index == first ? nearly_whole(*fit) : clear(*fit)))
      return index;
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

namespace {

constexpr double kStill = 0.5;     ///< px
constexpr double kBriefly = 0.05;  ///< of the frames: whatever rests for less moves
/// Where in the recording to look: not evenly, so that no circling motion is met in the same phase.
constexpr std::array<double, 4> kLookAt = {0.13, 0.38, 0.62, 0.87};
constexpr double kSeen = 0.2;  ///< of the score of the disc tracked

double distance(const Circle& a, const Circle& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

const DiscFit* nearest(const std::vector<DiscFit>& found, const Circle& place) {
  const DiscFit* best = nullptr;
  for (const DiscFit& f : found)
    if (distance(f.circle, place) < place.radius &&
        (!best || distance(f.circle, place) < distance(best->circle, place)))
      best = &f;
  return best;
}

/// The discs of a later frame that were not there in the first.
std::vector<Circle> newcomers(const std::vector<DiscFit>& found, const std::vector<DiscFit>& at_first,
                              const DiscFit& part) {
  std::vector<Circle> out;
  for (const DiscFit& f : found) {
    const bool known = std::ranges::any_of(at_first, [&](const DiscFit& other) {
      return distance(f.circle, other.circle) < std::max(f.circle.radius, other.circle.radius);
    });
    if (!known && f.score > kSeen * part.score) out.push_back(f.circle);
  }
  return out;
}

}  // namespace

std::int64_t frames_at_rest(const Track& track) {
  const TrackPoint* start = nullptr;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok) continue;
    if (!start) start = &p;
    if (std::hypot(p.x - start->x, p.y - start->y) > kStill) return static_cast<std::int64_t>(k);
  }
  return static_cast<std::int64_t>(track.points.size());
}

std::optional<DiscQuestion> question_of_rest(
    FrameSource& source, std::int64_t first, const Track& track,
    const std::function<std::vector<DiscFit>(const Picture&)>& find) {
  const auto total = static_cast<std::int64_t>(track.points.size());
  const std::int64_t rested = frames_at_rest(track);
  const auto seen = std::ranges::find(track.points, TrackStatus::ok, &TrackPoint::status);
  if (total < 2 || seen == track.points.end() ||
      static_cast<double>(rested) < kBriefly * static_cast<double>(total))
    return std::nullopt;
  const auto at_first = find(source.read(first));
  if (at_first.empty()) return std::nullopt;
  const Circle start{seen->x, seen->y, at_first.front().circle.radius};
  const DiscFit* part = nearest(at_first, start);
  if (!part) return std::nullopt;
  for (const double share : kLookAt) {
    const auto place = static_cast<std::int64_t>(share * static_cast<double>(total - 1));
    const auto found = find(source.read(first + place));
    const TrackPoint& p = track.points[static_cast<std::size_t>(place)];
    const Circle expected =
        p.status == TrackStatus::ok ? Circle{p.x, p.y, part->circle.radius} : part->circle;
    const DiscFit* here = nearest(found, expected);
    if (!here) continue;
    if (auto all = discs_alike(found, *here); all.size() > 1)
      return DiscQuestion{first + place, rested, std::move(all)};
    if (rested < total) continue;
    if (auto others = newcomers(found, at_first, *part); !others.empty()) {
      others.insert(others.begin(), here->circle);
      return DiscQuestion{first + place, rested, std::move(others)};
    }
  }
  return std::nullopt;
}

}  // namespace tribotrack::vision
