#include "vision/following/template_average.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "vision/kernels/bspline.h"
#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr int kSurroundings = 4;  ///< px around the template that its spline looks at
constexpr int kBorder = 8;        ///< more of each frame, so that its own spline is good there

struct Seen {
  std::int64_t index;
  Pose pose;
  double ncc;
};

std::vector<Seen> follow_some(FrameSource& source, const Picture& first, std::int64_t index,
                              std::int64_t last, const Pattern& pattern, FollowOptions follow, int frames) {
  follow.search_whole_frame = false;
  PatternFollower follower(first, index, pattern, follow);
  std::vector<Seen> seen;
  for (std::int64_t k = index + 1; k <= std::min(last, index + frames - 1); ++k)
    if (const FollowStep step = follower.step(source, k); step.status == TrackStatus::ok)
      seen.push_back({k, step.sighting->pose, step.sighting->ncc});
  return seen;
}

double median_score(const std::vector<Seen>& seen) {
  std::vector<double> scores;
  for (const Seen& s : seen) scores.push_back(s.ncc);
  return median(scores);
}

/// Adds the frame, moved back by the pose, to the sums over `area`. False where it reaches out of the
/// picture.
bool add_aligned(FrameSource& source, const Seen& seen, const Rect& area, Picture& sums) {
  const int whole_x = static_cast<int>(std::lround(seen.pose.dx));
  const int whole_y = static_cast<int>(std::lround(seen.pose.dy));
  const Rect moved{area.x + whole_x, area.y + whole_y, area.width, area.height};
  const Rect bounds = source.bounds();
  if (!bounds.contains(moved)) return false;
  const int left = std::min(kBorder, moved.x), top = std::min(kBorder, moved.y);
  const Rect window{moved.x - left, moved.y - top,
                    std::min(moved.width + left + kBorder, bounds.width - moved.x + left),
                    std::min(moved.height + top + kBorder, bounds.height - moved.y + top)};
  Picture picture, aligned(area.width, area.height);
  source.read(seen.index, window, picture);
  QuinticSpline(picture).sample_window(left + seen.pose.dx - whole_x, top + seen.pose.dy - whole_y,
                                       area.width, area.height, aligned.levels().data(), nullptr, nullptr);
  for (std::size_t i = 0; i < aligned.levels().size(); ++i) sums.levels()[i] += aligned.levels()[i];
  return true;
}

}  // namespace

AveragedTemplate average_template(FrameSource& source, const Picture& first, std::int64_t index,
                                  std::int64_t last, const Pattern& pattern, const FollowOptions& follow,
                                  const TemplateAverageOptions& options) {
  AveragedTemplate out;
  const auto seen = follow_some(source, first, index, last, pattern, follow, options.frames);
  if (seen.size() < 3) return out;
  const Rect& w = pattern.window;
  const int x0 = std::max(0, w.x - kSurroundings), y0 = std::max(0, w.y - kSurroundings);
  const int x1 = std::min(first.width(), w.x + w.width + kSurroundings);
  const int y1 = std::min(first.height(), w.y + w.height + kSurroundings);
  const Rect area{x0, y0, x1 - x0, y1 - y0};
  Picture sums(area.width, area.height);
  for (int y = 0; y < area.height; ++y)
    std::copy_n(first.row(y0 + y).begin() + x0, area.width, sums.row(y).begin());
  const double least = options.score_share * median_score(seen);
  for (const Seen& s : seen)
    if (s.ncc >= least && add_aligned(source, s, area, sums)) ++out.frames;
  if (out.frames < 4) return {};
  out.averaged = first;
  for (int y = 0; y < area.height; ++y)
    for (int x = 0; x < area.width; ++x)
      out.averaged.at(x0 + x, y0 + y) = sums.at(x, y) / static_cast<float>(out.frames);
  return out;
}

}  // namespace tribotrack::vision
