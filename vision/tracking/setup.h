// What the first frames say of the part, and what its tracking needs for it.
#pragma once

#include <optional>

#include "vision/following/pattern_follower.h"
#include "vision/following/template_average.h"
#include "vision/tracking/plan_costs.h"
#include "vision/tracking/target.h"

namespace tribotrack::vision {

inline constexpr double kClickSd = 0.5;          ///< sd of a radius that no rim confirms, px
inline constexpr double kQuietTemplate = 0.002;  ///< added variance that is not worth averaging frames for

struct Setup {
  Pattern pattern;
  std::optional<DiscFit> rim;  ///< in the first frame
  FollowOptions follow;
  double ground_texture = 0;
  double template_noise_cost = 0;
  PlanCosts costs;
};

/// The disc's rim or the rectangle, its template's mask, and whether it shows rotation.
Setup plan_part(const Picture& first, FrameSource& source, const FrameRange& range,
                const TrackOptions& options, double noise_variance, TrackSummary& summary);
/// The template the part is followed with: averaged over the first frames where its noise matters.
AveragedTemplate quiet_template(FrameSource& source, const Picture& first, const FrameRange& range,
                                Setup& setup, TrackSummary& summary);

}  // namespace tribotrack::vision
