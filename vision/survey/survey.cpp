#include "vision/survey.h"

#include <algorithm>
#include <cmath>

#include "vision/discs/disc_detection.h"
#include "vision/discs/first_appearance.h"
#include "vision/survey/lamps.h"

namespace tribotrack::vision {
namespace {

constexpr int kFramesForDiscs = 8;
constexpr int kFramesForLamps = 160;
/// Frames at the beginning among which those for lamps are; all up to the last must be decoded where any is.
constexpr std::int64_t kLampSpan = 3000, kLampSpanDecoded = 600;
constexpr int kMostDiscs = 30;
constexpr double kSmallestRadius = 3;
constexpr double kSameRadius = 0.1;  ///< relative
constexpr double kNearItsPlace =
    1;  ///< of its radius: no other disc can be so near, and platforms circle by less
constexpr double kLeastNear = 10;  ///< px
constexpr double kMoves = 0.5;     ///< px: noise and the search move a disc at rest by less

DiscSearch all_discs() {
  DiscSearch search;
  search.min_radius = kSmallestRadius;
  return search;
}

double distance(const Circle& a, const Circle& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

bool like(const Circle& a, const Circle& b) {
  return std::abs(a.radius - b.radius) <= kSameRadius * b.radius + 0.5;
}

double near(const Circle& place) {
  return std::max(kLeastNear, kNearItsPlace * place.radius);
}

bool touches_lamp(const Circle& disc, const std::vector<SurveyedLamp>& lamps) {
  return std::ranges::any_of(lamps, [&](const SurveyedLamp& lamp) {
    return distance(disc, lamp.circle) < std::max(disc.radius, lamp.circle.radius) &&
           disc.radius < 3 * lamp.circle.radius;
  });
}

/// Where the discs of the first frame are in another one: first each that is still near its place, then those
/// that are left take the nearest that is as large.
void follow(std::vector<SurveyedDisc>& discs, const std::vector<DiscFit>& found) {
  std::vector<bool> taken(found.size(), false);
  const auto take = [&](SurveyedDisc& disc, double reach) {
    std::size_t best = found.size();
    for (std::size_t k = 0; k < found.size(); ++k)
      if (!taken[k] && like(found[k].circle, disc.circle) && distance(found[k].circle, disc.circle) < reach) {
        best = k;
        reach = distance(found[k].circle, disc.circle);
      }
    if (best == found.size()) return false;
    taken[best] = true;
    ++disc.seen_in;
    disc.moved_px = std::max(disc.moved_px, reach);
    return true;
  };
  std::vector<SurveyedDisc*> gone;
  for (SurveyedDisc& disc : discs)
    if (!take(disc, near(disc.circle))) gone.push_back(&disc);
  for (SurveyedDisc* disc : gone) take(*disc, 1e9);
}

/// Roles by how far each moved; `discs` are best first.
void assign_roles(std::vector<SurveyedDisc>& discs) {
  const auto walks = [](const SurveyedDisc& d) { return d.moved_px > near(d.circle); };
  auto part = std::ranges::find_if(discs, walks);
  // Of several that walk, the largest: specks of dirt are small.
  for (auto other = discs.begin(); other != discs.end(); ++other)
    if (part != discs.end() && walks(*other) &&
        other->circle.radius > part->circle.radius * (1 + kSameRadius))
      part = other;
  // Nothing walks: the largest of those that are seen well.
  if (part == discs.end())
    part = std::ranges::max_element(discs, {}, [](const SurveyedDisc& d) { return d.circle.radius; });
  for (auto disc = discs.begin(); disc != discs.end(); ++disc) {
    if (disc == part)
      disc->role = DiscRole::part;
    else if (walks(*disc))
      disc->role = DiscRole::like_part;
    else
      disc->role = disc->moved_px > kMoves ? DiscRole::mark : DiscRole::resting;
  }
  // What lies within the part is on it: dots, a hole, a highlight.
  const Circle whole = part->circle;
  std::erase_if(discs, [&](const SurveyedDisc& d) {
    return d.role != DiscRole::part && distance(d.circle, whole) < whole.radius &&
           d.circle.radius < whole.radius;
  });
  std::ranges::stable_sort(discs, {}, [](const SurveyedDisc& d) {
    return d.role == DiscRole::part        ? 0
           : d.role == DiscRole::like_part ? 1
           : d.role == DiscRole::mark      ? 2
                                           : 3;
  });
}

}  // namespace

const SurveyedDisc* Survey::part() const {
  return discs.empty() ? nullptr : &discs.front();
}

const SurveyedDisc* Survey::mark() const {
  const auto mark = std::ranges::find(discs, DiscRole::mark, &SurveyedDisc::role);
  return mark == discs.end() ? nullptr : &*mark;
}

Survey survey(FrameSource& source) {
  const std::int64_t last = source.info().frame_count - 1;
  Survey seen;
  const std::int64_t span = std::min(last + 1, source.info().decoded ? kLampSpanDecoded : kLampSpan);
  seen.lamps = find_lamps(source, spread_frames(span, kFramesForLamps));
  const std::int64_t first = arrival_anywhere(source, 0, last, {}).value_or(0);
  seen.frame = source.number(first);
  std::vector<std::int64_t> frames = spread_frames(last - first + 1, kFramesForDiscs);
  seen.frames_looked_at = static_cast<int>(frames.size());
  for (const std::int64_t frame : frames) {
    auto found = find_discs(source.read(first + frame), all_discs(), kMostDiscs);
    std::erase_if(found, [&](const DiscFit& fit) { return touches_lamp(fit.circle, seen.lamps); });
    if (frame == 0)
      for (const DiscFit& fit : found) seen.discs.push_back({fit.circle, fit.coverage, 0, 1});
    else
      follow(seen.discs, found);
  }
  if (!seen.discs.empty()) assign_roles(seen.discs);
  return seen;
}

}  // namespace tribotrack::vision
