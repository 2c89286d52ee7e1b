#include "vision/tracking/target.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vision/discs/first_appearance.h"

namespace tribotrack::vision {
namespace {

constexpr double kGivenCapture = 3;  ///< px a user's click may be wrong

double capture_of(const Circle& given) {
  return std::max(kGivenCapture, 0.03 * given.radius);
}

bool whole_in(const Rect& picture, const Circle& c) {
  return c.x - c.radius >= -0.5 && c.y - c.radius >= -0.5 && c.x + c.radius <= picture.width - 0.5 &&
         c.y + c.radius <= picture.height - 0.5;
}

Rect all_of(const Picture& picture) {
  return {0, 0, picture.width(), picture.height()};
}

DiscSearch search_for_part(const TrackOptions& options) {
  DiscSearch search;
  if (options.marker.kind == MarkerChoice::Kind::circle) {
    search.keep_out = options.marker.circle;
    search.keep_out->radius += capture_of(*search.keep_out);
  }
  return search;
}

}  // namespace

std::optional<DiscFit> refined(const Picture& first, const Circle& given) {
  auto fit = fit_disc(first, given, capture_of(given));
  if (fit && !whole_in(all_of(first), fit->circle)) fit.reset();
  return fit;
}

void check_whole(const Picture& first, const Circle& c, const FrameSource& source, const char* what) {
  if (whole_in(all_of(first), c) && c.radius >= 2) return;
  throw InputError(
      fmt::format("{}: the {} at ({:.1f}, {:.1f}) px with radius {:.1f} px is not wholly in the {} x {} "
                  "picture; give its "
                  "place in the first analysed frame, or start at a frame in which it is whole",
                  source.info().path.string(), what, c.x, c.y, c.radius, first.width(), first.height()));
}

void leave_out_lamp(std::vector<DiscFit>& found, const TrackOptions& options) {
  if (!options.gate) return;
  std::erase_if(found, [&](const DiscFit& f) {
    return std::hypot(f.circle.x - options.gate->x, f.circle.y - options.gate->y) <
           std::max(options.gate->radius, f.circle.radius);
  });
}

std::int64_t first_appearance(FrameSource& source, const FrameRange& range, const TrackOptions& options) {
  const std::int64_t first = range.first;
  switch (options.target.kind) {
    case Target::Kind::rectangle:
      break;
    case Target::Kind::disc:
      if (!whole_in(source.bounds(), options.target.disc)) break;
      return arrival_at(source, first, range.last, options.target.disc, capture_of(options.target.disc))
          .value_or(first);
    case Target::Kind::find_disc:
      // A marker or a lamp left to be found is round, too: then the first frame must hold the part.
      if (options.marker.kind != MarkerChoice::Kind::find && !options.gate)
        return arrival_anywhere(source, first, range.last, search_for_part(options)).value_or(first);
  }
  return first;
}

DiscFit find_part(const Picture& first, const FrameSource& source, const TrackOptions& options) {
  const DiscSearch search = search_for_part(options);
  auto found = find_discs(first, search, 5);
  leave_out_lamp(found, options);
  if (found.empty())
    throw InputError(source.info().path.string() +
                     ": no disc was found in the first analysed frame; give it with --disc X,Y,R");
  DiscFit best = found.front();
  if (search.keep_out)
    for (const DiscFit& other : found)
      if (other.score > 0.5 * found.front().score && other.circle.radius > best.circle.radius) best = other;
  return best;
}

}  // namespace tribotrack::vision
