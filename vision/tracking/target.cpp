#include "vision/tracking/target.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vision/discs/disc_detection.h"
#include "vision/discs/first_appearance.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

constexpr double kWhole = 0.85;      ///< of the rim is seen: nothing covers the disc
constexpr int kMostDiscs = 30;       ///< looked for in a picture
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
  constexpr double kMuchLarger = 3;  // than the lamp: a disc that somebody took for one
  std::erase_if(found, [&](const DiscFit& f) {
    return f.circle.radius < kMuchLarger * options.gate->radius &&
           std::hypot(f.circle.x - options.gate->x, f.circle.y - options.gate->y) <
               std::max(options.gate->radius, f.circle.radius);
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
      std::hypot(nearest.x - given.x, nearest.y - given.y)));
}

/// Where the given disc is first seen; elsewhere only if nothing in the first frame was meant.
Appearance appearance_of_given(FrameSource& source, const FrameRange& range, const Circle& given) {
  const double capture = capture_of(given);
  if (arrival_at(source, range.first, range.first, given, capture)) return {range.first, {}};
  const auto others = find_discs(source.read(range.first), {}, kMostDiscs);
  const DiscFit* nearest = nearest_like(others, given);
  const double away = nearest ? std::hypot(nearest->circle.x - given.x, nearest->circle.y - given.y) : 0;
  // One that is covered in part may be the given one, whose rim pulls the circle away.
  if (nearest && nearest->coverage > kWhole && away > capture && away < given.radius + capture)
    refuse_misplaced(source, range.first, given, nearest->circle);
  const auto arrival = arrival_at(source, range.first, range.last, given, capture);
  if (!arrival && nearest && away > capture) refuse_misplaced(source, range.first, given, nearest->circle);
  if (!arrival) return {range.first, {}};
  std::string warning = fmt::format("no disc is seen at --disc {} before frame {}: tracking begins there",
                                    place_of(given), source.number(*arrival));
  if (nearest && away > capture)
    warning += fmt::format("; frame {} shows one at {}, {:.1f} px away", source.number(range.first),
                           place_of(nearest->circle), away);
  return {*arrival, warning};
}

}  // namespace

Appearance first_appearance(FrameSource& source, const FrameRange& range, const TrackOptions& options) {
  const std::int64_t first = range.first;
  switch (options.target.kind) {
    case Target::Kind::rectangle:
      break;
    case Target::Kind::disc:
      if (!whole_in(source.bounds(), options.target.disc)) break;
      return appearance_of_given(source, range, options.target.disc);
    case Target::Kind::find_disc:
      // A marker or a lamp left to be found is round, too: then the first frame must hold the part.
      if (options.marker.kind != MarkerChoice::Kind::find && !options.gate)
        return {arrival_anywhere(source, first, range.last, search_for_part(options)).value_or(first), {}};
  }
  return {first, {}};
}

std::vector<DiscFit> discs_in(const Picture& picture, const TrackOptions& options, double beside_best) {
  DiscSearch search = search_for_part(options);
  search.beside_best = beside_best;
  auto found = find_discs(picture, search, kMostDiscs);
  leave_out_lamp(found, options);
  return found;
}

DiscFit find_part(const Picture& first, const FrameSource& source, std::int64_t index,
                  const TrackOptions& options) {
  const auto found = discs_in(first, options, kAsLarge);
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
    const std::int64_t frame = source.number(index);
    const std::string what = fmt::format("{}: {} discs in frame {} have an equal right to be the part",
                                         source.info().path.string(), all.size(), frame);
    throw AmbiguousTarget(what, frame, true, std::move(all));
  }
  return best;
}

void ask_if_it_rests(FrameSource& source, std::int64_t start, const Track& track, const Circle& disc,
                     const TrackOptions& options) {
  if (options.target.kind != Target::Kind::find_disc || options.marker.kind == MarkerChoice::Kind::find)
    return;
  // Beside a disc that moves in the end those matter that are alike; beside one that never does, any.
  const bool moves = frames_at_rest(track) < static_cast<std::int64_t>(track.points.size());
  auto question = question_of_rest(source, start, track, [&](const Picture& picture) {
    return discs_in(picture, options, moves ? kAsLarge : 0);
  });
  if (!question) return;
  const std::int64_t frame = source.number(question->index);
  const bool for_ever = question->rested == static_cast<std::int64_t>(track.points.size());
  const std::string what = fmt::format(
      "{}: the disc found in frame {} rests {}, and frame {} shows {} discs that may be the part",
      source.info().path.string(), source.number(start),
      for_ever ? "for ever"
               : fmt::format("until frame {0} (is it the part? --disc {1:.1f},{2:.1f},{3:.1f} --frames {0}:)",
                             source.number(start + question->rested - 1), disc.x, disc.y, disc.radius),
      frame, question->discs.size());
  throw AmbiguousTarget(what, frame, false, std::move(question->discs));
}

}  // namespace tribotrack::vision
