#include "fit/slides/prepare.h"

#include <cstddef>

#include "fit/slides/blows.h"
#include "fit/slides/incline.h"
#include "fit/slides/slide_spin.h"

namespace tribotrack::fit::internal {
namespace {

/// A blow to a part slower than this share of its speed afterwards is what sets it sliding.
constexpr double kFromRest = 0.2;

template <class T>
void keep(std::vector<T>& column, const Stretch& stretch) {
  if (column.size() < stretch.last) return;
  column.erase(column.begin() + static_cast<std::ptrdiff_t>(stretch.last), column.end());
  column.erase(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(stretch.first));
}

void cut(TrackTable& track, const Stretch& stretch) {
  keep(track.frame, stretch);
  keep(track.time, stretch);
  keep(track.position, stretch);
  keep(track.covariance, stretch);
  keep(track.shared, stretch);
  keep(track.angle, stretch);
  keep(track.angle_sigma, stretch);
  keep(track.marker, stretch);
  keep(track.marker_sigma, stretch);
}

Blow blow_of(const TrackTable& track, const FoundBlow& found) {
  Blow blow;
  blow.frame = found.row < track.frame.size() ? track.frame[found.row] : static_cast<std::int64_t>(found.row);
  blow.time = track.time[found.row];
  blow.speed_before = found.before.norm();
  blow.speed_after = found.after.norm();
  blow.jump = (found.after - found.before).norm();
  return blow;
}

}  // namespace

std::vector<SlideResult> prepare_slides(Problem& problem) {
  std::vector<SlideResult> slides;
  for (TrajectoryRun& run : problem.trajectory_runs) {
    if (!run.free_slide) continue;
    SlideResult slide;
    slide.run = run.name;
    slide.slope = run.slope;
    const std::vector<FoundBlow> found = find_blows(run.track);
    const Stretch stretch = longest_clean_stretch(run.track, found);
    for (const FoundBlow& blow : found) {
      const bool starts_it = blow.row <= stretch.first && blow.row + 1 >= stretch.first &&
                             blow.before.norm() < kFromRest * blow.after.norm();
      if (!starts_it) slide.blows.push_back(blow_of(run.track, blow));
    }
    cut(run.track, stretch);
    if (run.slope != 0) {
      cut(run.track, sliding_stretch(run.track));
      if (run.downhill.isZero()) run.downhill = downhill_of(run);
    } else if (!run.spin) {
      run.spin = first_slide_spin(run);
    }
    slide.spin_seen = run.spin.has_value();
    slides.push_back(slide);
  }
  return slides;
}

}  // namespace tribotrack::fit::internal
