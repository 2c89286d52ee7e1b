// What a track's summary reports: counts, the plan's stages, warnings.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vision/edge/radius.h"
#include "vision/following/pattern_follower.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

/// Frames by their status, and the quality gate.
FrameCounts count(const Track& track, double max_lost_share);

PlanStage bad_pixels_stage(std::size_t found);
/// Levels rms: texture of the ground around the disc, and the noise.
PlanStage mask_stage(bool beyond_rim, double texture, double noise);
/// `limit_theta` rad: Cramer-Rao bound of the rotation; `visible`: it is small enough for a first frame.
PlanStage rotation_stage(bool on, bool visible, double limit_theta);
/// A single template's noise adds `noise_cost` to the variance, relative, and `adds_px` to the standard
/// deviation. `agreeing` frames: nothing where averaging was not tried.
PlanStage template_stage(bool may_turn, double noise_cost, std::optional<int> agreeing, double adds_px);
PlanStage no_marker_stage();
PlanStage marker_stage(const Circle& marker);
/// What the ground shows; `learnt_from` frames, 0: it is not followed.
PlanStage ground_marker_stage(const std::string& ground, int learnt_from);
/// Stages that only some frames need.
std::vector<PlanStage> search_stages(const FollowEffort& effort, std::int64_t frames);

/// In how many of the frames in which the part was seen the rim alone measures it.
PlanStage rim_stage(std::int64_t by_rim, std::int64_t seen);

/// What lies beyond the edge that is seen.
PlanStage chamfer_stage(const OuterEdge& edge, bool given);

std::string no_rim_warning(const char* what, const Circle& given);
std::string texture_lost_warning(std::int64_t frames);
/// Where the residual beyond the noise is large; levels rms.
std::optional<std::string> excess_warning(double excess, double noise);
/// A disc that was found, not given, and never moves may be a mark on the table.
std::optional<std::string> stillness_warning(const Track& track, const Circle& disc);
/// One that goes where the ground or the mark goes may be fixed to it.
std::optional<std::string> carried_warning(const Track& track, const Circle& disc);

/// Which of several that look alike is the part cannot be told since this frame.
std::string alike_warning(std::int64_t frame);
/// What is taken for a part that has left and come back, from point number `begin` until it is lost again,
/// must move, or else it is a mark on the ground: then those points become lost, and it is said.
std::optional<std::string> without_a_mark(Track& track, std::size_t begin);

/// Appends.
void add(std::vector<PlanStage>& plan, std::vector<PlanStage> stages);
void add(std::vector<std::string>& warnings, std::vector<std::string> more);
void add(std::vector<std::string>& warnings, std::optional<std::string> warning);

}  // namespace tribotrack::vision
