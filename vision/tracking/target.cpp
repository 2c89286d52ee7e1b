#include "vision/tracking/target.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "vision/io/levels.h"
#include "vision/kernels/plane.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

constexpr double kWhole = 0.85;       ///< of the rim is seen: nothing covers the disc
constexpr int kMostDiscs = 30;        ///< looked for in a picture
constexpr double kGivenCapture = 3;   ///< px a user's click may be wrong
constexpr std::int64_t kLooks = 100;  ///< whole frames searched on the way, at most
constexpr double kMargin = 8;         ///< px around the disc that the rim's fit sees
constexpr double kLeastContrast = 4;  ///< grey levels
constexpr double kClick = 2;          ///< px that the radius of a click may be off
constexpr double kAsLarge = 0.75;     ///< ratio of the radii of discs that are alike, at least
constexpr double kSeenAsWell = 0.5;   ///< of the score
constexpr double kSameSize = 0.9, kSameContrast = 0.67, kSeen = 0.2;
constexpr double kAboutAsLarge = 0.67;  ///< ratio of the radii
constexpr double kStill = 0.5;          ///< px
constexpr double kBriefly = 0.05;       ///< of the frames: whatever rests for less moves
/// Where in the recording to look: not evenly, so that no circling motion is met in the same phase.
constexpr std::array<double, 4> kLookAt = {0.13, 0.38, 0.62, 0.87};

double capture_of(const Circle& given) {
  return std::max(kGivenCapture, 0.03 * given.radius);
}

bool whole_in(const Rect& picture, const Circle& c) {
  return c.x - c.radius >= -0.5 && c.y - c.radius >= -0.5 && c.x + c.radius <= picture.width - 0.5 &&
         c.y + c.radius <= picture.height - 0.5;
}

double ratio(double a, double b) {
  const double low = std::min(a, b), high = std::max(a, b);
  return low > 0 ? low / high : (high < 0 ? high / low : 0);
}

/// The nearest to a place of the discs that `may` be meant. Null if none is.
const DiscFit* nearest(std::span<const DiscFit> found, const Circle& place, const auto& may) {
  const DiscFit* best = nullptr;
  for (const DiscFit& f : found)
    if (may(f) && (!best || distance(f.circle, place) < distance(best->circle, place))) best = &f;
  return best;
}

/// Of equal right to be the part: as large, to a quarter, and seen nearly as well; or as large to a tenth, of
/// the same contrast and seen at all (a neighbour may touch its rim).
bool alike(const DiscFit& other, const DiscFit& part) {
  const double size = ratio(other.circle.radius, part.circle.radius);
  if (size > kAsLarge && other.score > kSeenAsWell * part.score) return true;
  return size > kSameSize && ratio(other.contrast, part.contrast) > kSameContrast &&
         other.score > kSeen * part.score;
}

/// `part` and the others that are alike, from left to right; what lies within the part's rim is not another.
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

DiscSearch search_for_part(const TrackOptions& options) {
  DiscSearch search;
  if (options.marker.kind == MarkerChoice::Kind::circle) {
    search.keep_out = options.marker.circle;
    search.keep_out->radius += capture_of(*search.keep_out);
  }
  return search;
}

/// All that may be the part, best first; `beside_best` as in DiscSearch.
std::vector<DiscFit> discs_in(const Picture& picture, const TrackOptions& options, double beside_best) {
  DiscSearch search = search_for_part(options);
  search.beside_best = beside_best;
  auto found = find_discs(picture, search, kMostDiscs);
  leave_out_lamp(found, options);
  return found;
}

}  // namespace

void check_whole(const Picture& first, const Circle& c, const FrameSource& source, const char* what) {
  if (whole_in(bounds_of(first), c) && c.radius >= 2) return;
  throw InputError(
      fmt::format("{}: the {} at ({:.1f}, {:.1f}) px with radius {:.1f} px is not wholly in the {} x {} "
                  "picture; give its "
                  "place in the first analysed frame, or start at a frame in which it is whole",
                  source.info().path.string(), what, c.x, c.y, c.radius, first.width(), first.height()));
}

void leave_out_lamp(std::vector<DiscFit>& found, const TrackOptions& options) {
  if (!options.gate) return;
  constexpr double kMuchLarger = 3;  // than the lamp: a disc that somebody took for one
  std::erase_if(found, [&](const DiscFit& f) {
    return f.circle.radius < kMuchLarger * options.gate->radius &&
           distance(f.circle, *options.gate) < std::max(options.gate->radius, f.circle.radius);
  });
}

namespace {

std::string place_of(const Circle& c) {
  return fmt::format("{:.1f},{:.1f},{:.1f}", c.x, c.y, c.radius);
}

/// A given disc that is not there while another lies across the given circle was meant for that one.
[[noreturn]] void refuse_misplaced(const FrameSource& source, std::int64_t index, const Circle& given,
                                   const Circle& nearest) {
  throw InputError(fmt::format(
      "{}: frame {} shows no disc at --disc {}; the nearest of about that size is --disc {}, {:.1f} px away: "
      "give that, or start with --frames at a frame in which the part lies at the given place",
      source.info().path.string(), source.number(index), place_of(given), place_of(nearest),
      distance(nearest, given)));
}

/// Of about the given radius, seen nearly all the way round, and more than what rounding or a coder leaves of
/// an even ground, noiseless as it is.
bool may_be(const DiscFit& fit, const Circle& given) {
  return fit.coverage >= DiscSearch{}.min_coverage &&
         std::abs(fit.circle.radius - given.radius) < std::max(kClick, given.radius / 3) &&
         std::abs(fit.contrast) >= kLeastContrast;
}

}  // namespace

std::optional<DiscFit> refined(const Picture& first, const Circle& given) {
  auto fit = fit_disc(first, given, capture_of(given));
  if (fit && !(may_be(*fit, given) && whole_in(bounds_of(first), fit->circle))) fit.reset();
  return fit;
}

namespace {

/// The first of these frames in which a rim as clear as that of a disc found by itself is seen at the given
/// place. Reads no more than the window about it.
std::optional<std::int64_t> arrival_at(FrameSource& source, std::int64_t first, std::int64_t last,
                                       const Circle& given) {
  const DiscSearch usual;
  const double capture = capture_of(given);
  const Rect window = window_about(
      {given.x, given.y}, given.radius + capture + std::max(kMargin, 0.2 * given.radius), source.bounds());
  Picture picture;
  for (std::int64_t index = first; index <= last; ++index) {
    source.read(index, window, picture);
    const auto fit = fit_disc(picture, {given.x - window.x, given.y - window.y, given.radius}, capture);
    if (fit && may_be(*fit, given) && std::abs(fit->contrast) >= usual.min_clarity * fit->residual_rms &&
        fit->blur <= usual.max_blur_share * fit->circle.radius)
      return index;
  }
  return std::nullopt;
}

/// Where the given disc is first seen; elsewhere only if nothing in the first frame was meant. There any rim
/// will do.
Appearance appearance_of_given(FrameSource& source, const FrameRange& range, const Circle& given) {
  const double capture = capture_of(given);
  const Picture first = source.read(range.first);
  if (const auto fit = fit_disc(first, given, capture); fit && may_be(*fit, given)) {
    if (!whole_in(source.bounds(), fit->circle)) return {range.first};
    return {range.first, {*fit}};
  }
  const auto others = find_discs(first, {}, kMostDiscs);
  const DiscFit* other = nearest(
      others, given, [&](const DiscFit& f) { return ratio(f.circle.radius, given.radius) > kAboutAsLarge; });
  const double away = other ? distance(other->circle, given) : 0;
  // One that is covered in part may be the given one, whose rim pulls the circle away.
  if (other && other->coverage > kWhole && away > capture && away < given.radius + capture)
    refuse_misplaced(source, range.first, given, other->circle);
  const auto arrival = arrival_at(source, range.first + 1, range.last, given);
  if (!arrival && other && away > capture) refuse_misplaced(source, range.first, given, other->circle);
  if (!arrival) return {range.first};
  std::string warning = fmt::format("no disc is seen at --disc {} before frame {}: tracking begins there",
                                    place_of(given), source.number(*arrival));
  if (other && away > capture)
    warning += fmt::format("; frame {} shows one at {}, {:.1f} px away", source.number(range.first),
                           place_of(other->circle), away);
  return {*arrival, {}, std::move(warning)};
}

/// A part that comes in over the edge is taken for the template once all its surroundings are seen.
bool has_room(const Circle& c, const Rect& all) {
  const double reach = c.radius + kMargin;
  return c.x >= reach && c.y >= reach && c.x + reach < all.width && c.y + reach < all.height;
}

}  // namespace

Appearance arrival_anywhere(FrameSource& source, std::int64_t first, std::int64_t last, DiscSearch search) {
  search.beside_best = kAsLarge;
  Appearance out{first};
  Picture picture;
  const auto seen = [&](std::int64_t index) {
    source.read(index, source.bounds(), picture);
    auto found = find_discs(picture, search, kMostDiscs);
    if (found.empty() || (index > first && !has_room(found.front().circle, source.bounds()))) return false;
    out = {index, std::move(found)};
    return true;
  };
  const std::int64_t step = std::max<std::int64_t>(1, (last - first) / kLooks);
  std::int64_t without = first;
  if (seen(first)) return out;
  for (std::int64_t with = first + step; without < last; with = std::min(with + step, last)) {
    if (!seen(with)) {
      without = with;
      continue;
    }
    while (with - without > 1) {
      const std::int64_t middle = without + (with - without) / 2;
      (seen(middle) ? with : without) = middle;
    }
    break;
  }
  return out;
}

Appearance first_appearance(FrameSource& source, const FrameRange& range, const TrackOptions& options) {
  switch (options.target.kind) {
    case Target::Kind::rectangle:
      break;
    case Target::Kind::disc:
      if (!whole_in(source.bounds(), options.target.disc)) break;
      return appearance_of_given(source, range, options.target.disc);
    case Target::Kind::find_disc:
      // A marker or a lamp left to be found is round, too: then the first frame must hold the part.
      if (options.marker.kind != MarkerChoice::Kind::find && !options.gate)
        return arrival_anywhere(source, range.first, range.last, search_for_part(options));
  }
  return {range.first};
}

DiscFit find_part(const Picture& first, const FrameSource& source, const Appearance& seen,
                  const TrackOptions& options) {
  const auto found = seen.discs.empty() ? discs_in(first, options, kAsLarge) : seen.discs;
  if (found.empty())
    throw InputError(source.info().path.string() +
                     ": no disc was found in the first analysed frame; give it with --disc X,Y,R");
  DiscFit best = found.front();
  if (options.marker.kind == MarkerChoice::Kind::circle)
    for (const DiscFit& other : found)
      if (other.score > 0.5 * found.front().score && other.circle.radius > best.circle.radius) best = other;
  // A marker that is to be found is round, too.
  if (options.marker.kind == MarkerChoice::Kind::find) return best;
  if (auto all = discs_alike(found, best); all.size() > 1) {
    const std::int64_t frame = source.number(seen.index);
    const std::string what = fmt::format("{}: {} discs in frame {} have an equal right to be the part",
                                         source.info().path.string(), all.size(), frame);
    throw AmbiguousTarget(what, frame, true, std::move(all));
  }
  return best;
}

namespace {

/// Frames at the beginning of the track in which the part stays where it was, to half a pixel; none where it
/// is not seen at all.
std::int64_t frames_at_rest(const Track& track) {
  const TrackPoint* start = nullptr;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok) continue;
    if (!start) start = &p;
    if (distance(p, *start) > kStill) return static_cast<std::int64_t>(k);
  }
  return start ? static_cast<std::int64_t>(track.points.size()) : 0;
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

void ask_if_it_rests(FrameSource& source, std::int64_t start, const Track& track, const DiscFit& part,
                     const TrackOptions& options) {
  const auto total = static_cast<std::int64_t>(track.points.size()), rested = frames_at_rest(track);
  if (options.target.kind != Target::Kind::find_disc || options.marker.kind == MarkerChoice::Kind::find ||
      total < 2 || static_cast<double>(rested) < kBriefly * static_cast<double>(total))
    return;
  // Beside a disc that moves in the end those matter that are alike; beside one that never does, any.
  const bool moves = rested < total;
  const auto find = [&](std::int64_t place) {
    return discs_in(source.read(start + place), options, moves ? kAsLarge : 0);
  };
  const auto at_first = moves ? std::vector<DiscFit>() : find(0);
  for (const double share : kLookAt) {
    const auto place = static_cast<std::int64_t>(share * static_cast<double>(total - 1));
    const auto found = find(place);
    const TrackPoint& p = track.points[static_cast<std::size_t>(place)];
    const Circle expected = p.status == TrackStatus::ok ? Circle{p.x, p.y, part.circle.radius} : part.circle;
    const DiscFit* here = nearest(
        found, expected, [&](const DiscFit& f) { return distance(f.circle, expected) < expected.radius; });
    if (!here) continue;
    auto discs = discs_alike(found, *here);
    if (discs.size() == 1 && !moves)
      for (const Circle& other : newcomers(found, at_first, part)) discs.push_back(other);
    if (discs.size() == 1) continue;
    const std::int64_t frame = source.number(start + place);
    const Circle& c = part.circle;
    const std::string what = fmt::format(
        "{}: the disc found in frame {} rests {}, and frame {} shows {} discs that may be the part",
        source.info().path.string(), source.number(start),
        moves ? fmt::format("until frame {0} (is it the part? --disc {1:.1f},{2:.1f},{3:.1f} --frames {0}:)",
                            source.number(start + rested - 1), c.x, c.y, c.radius)
              : "for ever",
        frame, discs.size());
    throw AmbiguousTarget(what, frame, false, std::move(discs));
  }
}

}  // namespace tribotrack::vision
