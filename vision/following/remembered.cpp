// What following remembers: where things were and how they moved, and how the part looked at first.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "vision/following/pattern_follower.h"
#include "vision/io/levels.h"
#include "vision/kernels/bspline.h"
#include "vision/kernels/median.h"
#include "vision/kernels/plane.h"
#include "vision/rotation/rotation.h"

namespace tribotrack::vision {

void MotionPrediction::add(std::int64_t frame, const Point& position) {
  if (!places_.empty() && places_.back().frame == frame) places_.pop_back();  // seen better
  if (!places_.empty()) {
    const Point predicted = at(frame);
    const auto gap = static_cast<double>(std::max<std::int64_t>(1, frame - last_frame()));
    const double error = distance(position, predicted) / gap;
    constexpr double kMemory = 0.2;  ///< weight of the newest error in the running mean
    error_squared_ += kMemory * (error * error - error_squared_);
    top_speed_ = std::max(top_speed_, distance(position, last()) / gap);
  }
  places_.push_back({frame, position});
  if (places_.size() > 2) places_.pop_front();
}

Point MotionPrediction::at(std::int64_t frame) const {
  const Place& b = places_.back();
  if (places_.size() < 2) return b.position;
  const Place& a = places_.front();
  const double t = static_cast<double>(frame - b.frame) / static_cast<double>(b.frame - a.frame);
  return {b.position.x + t * (b.position.x - a.position.x), b.position.y + t * (b.position.y - a.position.y)};
}

double MotionPrediction::reach(std::int64_t frame) const {
  const auto gap = static_cast<double>(std::max<std::int64_t>(1, frame - last_frame()));
  return 2 + 3 * std::sqrt(error_squared_) * gap;
}

std::vector<Point> Distractors::unexplained(const std::vector<Point>& candidates) {
  struct Pair {
    double distance;
    std::size_t place, candidate;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < places_.size(); ++i)
    for (std::size_t j = 0; j < candidates.size(); ++j) {
      const double d = distance(places_[i], candidates[j]);
      if (d <= reach_) pairs.push_back({d, i, j});
    }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
  const std::vector<Point> before = places_;
  const auto spacing = [&](std::size_t i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < before.size(); ++j)
      if (j != i) nearest = std::min(nearest, distance(before[i], before[j]));
    return nearest;
  };
  std::size_t found = 0, moved = 0;
  std::vector<bool> place_taken(places_.size());
  std::vector<bool> explained(candidates.size());
  for (const Pair& pair : pairs) {
    if (place_taken[pair.place] || explained[pair.candidate]) continue;
    place_taken[pair.place] = explained[pair.candidate] = true;
    places_[pair.place] = candidates[pair.candidate];
    ++found;
    moved += pair.distance > 0.25 * spacing(pair.place);
  }
  all_moved_ = moved >= 2 && 2 * moved > found;
  std::vector<Point> left;
  for (std::size_t j = 0; j < candidates.size(); ++j)
    if (!explained[j]) left.push_back(candidates[j]);
  return left;
}

namespace {

constexpr double kScoreShare = 0.985;  ///< of the matches' median score: lower ones show something else
constexpr int kSurroundings = 4;       ///< px around the template that its spline looks at
constexpr int kBorder = 8;             ///< more of each frame, so that its own spline is good there

struct Seen {
  std::int64_t index;
  Pose pose;
  double ncc;
};

std::vector<Seen> follow_some(FrameSource& source, const Picture& first, std::int64_t index,
                              std::int64_t last, const Pattern& pattern, FollowOptions follow) {
  follow.search_whole_frame = false;
  PatternFollower follower(first, index, pattern, follow);
  std::vector<Seen> seen;
  for (std::int64_t k = index + 1; k <= std::min(last, index + kAveragedFrames - 1); ++k)
    if (const FollowStep step = follower.step(source, k); step.status == TrackStatus::ok)
      seen.push_back({k, step.sighting->pose, step.sighting->ncc});
  return seen;
}

/// Adds the frame, moved back by the pose, to the sums over `area`. False where it reaches out of the
/// picture.
bool add_aligned(FrameSource& source, const Seen& seen, const Rect& area, Picture& sums) {
  const int whole_x = static_cast<int>(std::lround(seen.pose.dx));
  const int whole_y = static_cast<int>(std::lround(seen.pose.dy));
  const Rect moved{area.x + whole_x, area.y + whole_y, area.width, area.height};
  if (!source.bounds().contains(moved)) return false;
  const Rect window = grown(moved, kBorder, source.bounds());
  Picture picture, aligned(area.width, area.height);
  source.read(seen.index, window, picture);
  QuinticSpline(picture).sample_window(moved.x - window.x + seen.pose.dx - whole_x,
                                       moved.y - window.y + seen.pose.dy - whole_y, area.width, area.height,
                                       aligned.levels().data(), nullptr, nullptr);
  for (std::size_t i = 0; i < aligned.levels().size(); ++i) sums.levels()[i] += aligned.levels()[i];
  return true;
}

}  // namespace

AveragedTemplate quiet_template(FrameSource& source, const Picture& first, std::int64_t index,
                                std::int64_t last, const Pattern& pattern, double noise_cost,
                                FollowOptions& follow) {
  AveragedTemplate out;
  if (noise_cost < kQuietTemplate) return out;
  const auto seen = follow_some(source, first, index, last, pattern, follow);
  if (seen.size() < 3) return out;
  const Rect area = grown(pattern.window, kSurroundings, bounds_of(first));
  Picture sums = part_of(first, area);
  std::vector<double> scores;
  for (const Seen& s : seen) scores.push_back(s.ncc);
  const double least = kScoreShare * median(scores);
  for (const Seen& s : seen)
    if (s.ncc >= least && add_aligned(source, s, area, sums)) ++out.frames;
  if (out.frames < 4) return {};
  out.averaged = first;
  for (int y = 0; y < area.height; ++y)
    for (int x = 0; x < area.width; ++x)
      out.averaged.at(area.x + x, area.y + y) = sums.at(x, y) / static_cast<float>(out.frames);
  follow.template_noise_share = 1.0 / out.frames;
  return out;
}

bool texture_returns(FrameSource& source, const Picture& first, std::int64_t index, std::int64_t last,
                     const Pattern& disc, double blur, const FollowOptions& options) {
  constexpr int kFrames = 16;
  constexpr int kSoonest = 6;         // frames after the first: a coder repeats what it has for some
  constexpr std::size_t kFewest = 4;  // comparisons from which to conclude
  FollowOptions follow = options;
  follow.rotation = true;
  SeenFrames frames{{.index = index, .centre = disc.centre}};
  for (const Seen& s : follow_some(source, first, index, std::min(last, index + kFrames), disc, follow))
    if (s.index - index >= kSoonest)
      frames.push_back({.index = s.index, .centre = {disc.centre.x + s.pose.dx, disc.centre.y + s.pose.dy}});
  if (frames.size() <= kFewest) return true;
  return !RingHarmonics(disc.radius, blur).usable() ||
         !follow_rotation(source, frames, disc.radius, blur).empty();
}

}  // namespace tribotrack::vision
