#include "vision/tracking/notes.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace tribotrack::vision {

void count(const Track& track, double max_lost_share, TrackSummary& summary) {
  const auto& points = track.points;
  summary.frames = static_cast<std::int64_t>(points.size());
  for (const TrackPoint& p : points) {
    summary.ok += p.status == TrackStatus::ok;
    summary.lost += p.status == TrackStatus::lost;
    summary.edge += p.status == TrackStatus::edge;
  }
  // Left for good: not seen again after an edge.
  std::size_t end = points.size();
  while (end > 0 && points[end - 1].status != TrackStatus::ok) --end;
  summary.left_for_good = end < points.size() && points[end].status == TrackStatus::edge;
  const std::size_t counted = summary.left_for_good ? end : points.size();
  for (std::size_t k = 0; k < counted; ++k) summary.lost_counted += points[k].status == TrackStatus::lost;
  summary.gate_passed = static_cast<double>(summary.lost_counted) <=
                        max_lost_share * static_cast<double>(std::max<std::int64_t>(1, summary.frames));
}

void note_effort(const FollowEffort& effort, const PlanCosts& costs, const Rect& picture,
                 TrackSummary& summary) {
  const auto frames = static_cast<double>(std::max<std::int64_t>(1, summary.frames));
  // A stage that is on works in some of the frames; one that is off would have worked in all.
  const auto share = [&](std::int64_t used) { return used > 0 ? static_cast<double>(used) / frames : 1; };
  constexpr double kMargin = 5;
  summary.plan.push_back(
      {"correlation over the predicted window", effort.window_searches > 0,
       fmt::format("refinement from the prediction proved the match in {:.1f} % of the frames",
                   100 * static_cast<double>(effort.proved_by_refinement) / frames),
       0, 0, share(effort.window_searches) * costs.window_search(kMargin)});
  summary.plan.push_back(
      {"search of the whole frame", effort.whole_frame_searches > 0,
       fmt::format("needed in {} frames, where the part was lost", effort.whole_frame_searches), 0, 0,
       share(effort.whole_frame_searches) * costs.whole_search(picture)});
}

double median_excess(std::vector<double>& excess) {
  if (excess.empty()) return 0;
  const auto middle = excess.begin() + static_cast<std::ptrdiff_t>(excess.size() / 2);
  std::nth_element(excess.begin(), middle, excess.end());
  return *middle;
}

void note_excess(double excess, double noise, TrackSummary& summary) {
  if (excess > 0.5 * noise)
    summary.warnings.push_back(
        fmt::format("the registration leaves {:.2f} grey levels rms beyond the noise of {:.2f} (moving "
                    "ground seen through "
                    "the rim, glare, compression): the standard deviations are widened accordingly",
                    excess, noise));
}

void note_stillness(const Track& track, TrackSummary& summary) {
  constexpr double kStill = 0.5;  // px
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  for (const TrackPoint& p : track.points) {
    if (p.status != TrackStatus::ok) continue;
    left = std::min(left, p.x);
    right = std::max(right, p.x);
    top = std::min(top, p.y);
    bottom = std::max(bottom, p.y);
  }
  const double range = std::hypot(right - left, bottom - top);
  if (summary.ok < 2 || range > kStill) return;
  summary.warnings.push_back(fmt::format(
      "the disc that was found at ({:.1f}, {:.1f}) px stays within {:.2f} px: if that is not the part, give "
      "the part with --disc X,Y,R",
      summary.disc.x, summary.disc.y, range));
}

std::string TrackSummary::brief_report() const {
  std::string text = fmt::format("{} frames: {} ok, {} lost, {} edge", frames, ok, lost, edge);
  if (refound > 0) text += fmt::format(", found again {} times", refound);
  if (absent_at_first > 0) text += fmt::format(", not there in the first {}", absent_at_first);
  if (left_for_good) text += ", left the picture for good";
  text += fmt::format("; noise {:.2f} grey levels, limit {:.4f} px", noise_levels, limit_px);
  if (disc.radius > 0)
    text += fmt::format("; disc at ({:.2f}, {:.2f}), radius {:.3f} px", disc.x, disc.y, disc.radius);
  if (!gate_passed) text += "; GATE FAILED: lost for more than the allowed share of frames";
  return text;
}

}  // namespace tribotrack::vision
