// What came of the tracking, in numbers and in words.
#pragma once

#include <vector>

#include "vision/following/pattern_follower.h"
#include "vision/tracker.h"
#include "vision/tracking/plan_costs.h"

namespace tribotrack::vision {

/// Frames by their status, and the quality gate.
void count(const Track& track, double max_lost_share, TrackSummary& summary);
/// The plan's stages that were needed in some frames only.
void note_effort(const FollowEffort& effort, const PlanCosts& costs, const Rect& picture,
                 TrackSummary& summary);
/// Grey levels rms beyond the noise, of the median frame.
double median_excess(std::vector<double>& excess);
/// A warning where that is much.
void note_excess(double excess, double noise, TrackSummary& summary);
/// What nobody pointed at and never moves may be a mark on the table.
void note_stillness(const Track& track, TrackSummary& summary);

}  // namespace tribotrack::vision
