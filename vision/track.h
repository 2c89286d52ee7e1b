// A track: the part's position in every frame, with its uncertainty.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

enum class TrackStatus {
  ok,      ///< measured in this frame
  lost,    ///< not found; no position
  edge,    ///< reaches out of the picture; no position
  repeat,  ///< the same picture as the frame before; no position
};

const char* to_string(TrackStatus status);

/// The marker in one frame (fixed to the platform).
struct MarkerPoint {
  double x = 0, y = 0;  ///< px
  double sigma = 0;     ///< px, per axis: rms of the two
  double ncc = 0;
  /// Where the axes differ (a brushed ground): standard deviations, px, and correlation; else 0.
  double sigma_x = 0, sigma_y = 0, rho_xy = 0;
};

/// Rotation of the part since the first frame in which its texture shows it.
struct Rotation {
  double theta = 0;  ///< rad, counter-clockwise as seen (y up); not wrapped
  double sigma = 0;  ///< standard deviation, rad
};

/// One frame. Positions are meaningful only for status ok.
struct TrackPoint {
  std::int64_t frame = 0;                       ///< the recording's own number
  double time_s = 0;                            ///< 0 at the recording's first stored image
  double x = 0, y = 0;                          ///< the part's centre, px
  double sigma_x = 0, sigma_y = 0, rho_xy = 0;  ///< standard deviations, px, and correlation
  double ncc = 0;                               ///< normalised cross-correlation with the template, -1 .. 1
  TrackStatus status = TrackStatus::lost;
  std::optional<MarkerPoint> marker;  ///< where a marker is followed and was found
  std::optional<Rotation> rotation;   ///< where it is seen
  std::optional<double> gate;         ///< the lamp's mean grey level, where a lamp is given
};

/// Millimetres per pixel and where they come from.
struct Scale {
  double mm_per_px = 0;
  double sd = 0;       ///< mm/px
  std::string source;  ///< "given", "part's diameter"
};

struct Track {
  std::vector<TrackPoint> points;  ///< one per analysed frame, in order
  bool has_marker = false;
  bool has_gate = false;
  bool has_rotation = false;  ///< the part's texture shows how it turns
  /// Frame of the first point that is ok; of the first of all where none is. Not for an empty track.
  std::int64_t first_seen() const;
};

/// Corrects for a rolling shutter, which reads the rows one after the other, `row_time` s apart (negative:
/// from the bottom up). Every point gets the time at which the part's own row was read, relative to
/// `middle_row`; the mark, whose row was read at another time, is moved to that time by its velocity
/// between the neighbouring frames.
void shift_to_rows(Track& track, double row_time, double middle_row);

/// A stage of the work that a scene may or may not need.
struct PlanStage {
  std::string name;
  bool on = false;
  std::string reason;  ///< with its figure
  /// Error in a position, px, that leaving this stage out adds (off) or would add (on). 0 only where leaving
  /// it out is exact; empty where nobody computed it.
  std::optional<double> error_bound_px = {};
};

/// Wall-clock time spent in a stage, the stages it called not included: the stages add up to the whole.
struct StageTime {
  std::string name;
  double seconds = 0;
};

/// Frames by their status.
struct FrameCounts {
  std::int64_t frames = 0, ok = 0, lost = 0, edge = 0, repeats = 0;
  std::int64_t refound = 0;          ///< times the part was found again after it had been lost
  std::int64_t absent_at_first = 0;  ///< frames before the part was there; counted in `lost`, too
  /// Lost frames, without those before the part was there and after it had left the picture for good.
  std::int64_t lost_counted = 0;
  /// Quality: lost_counted / frames <= TrackOptions::max_lost_share, and not rests_for_ever.
  bool gate_passed = true;
  bool rests_for_ever = false;  ///< a disc that was found by itself and never moves is no moving part
  bool left_for_good = false;
};

/// Test of the model's standard deviations on the recording itself: ratios of the observed to the predicted
/// scatter, before they were widened; 1 is as predicted. Empty where there are too few data.
/// `high_frequency` is of the coordinate, x or y, that is further off.
struct Audit {
  std::int64_t frames = 0;               ///< whose halves were compared
  std::optional<double> halves_x;        ///< positions from the part's left and right half
  std::optional<double> halves_y;        ///< from its top and bottom half
  std::optional<double> high_frequency;  ///< scatter from frame to frame, if the motion is slow
  double white_factor = 1;               ///< what every covariance is multiplied by
  /// Correlated errors added to each coordinate, px, and their correlation time, s.
  double slow_sd = 0, slow_time = 0;
};

/// Effect of lossy compression on a track (vision/coding).
struct CodedErrors {
  std::string coder, settings;
  bool known = false;  ///< which one it was, and with which settings
  /// Means over the frames: the quantiser's step at the part's edge, grey levels, 0 unknown; shares of the
  /// edge that are predicted from the same place of another frame, and from elsewhere.
  double step = 0, still = 0, moving = 0;
  double unnoticed = 0;  ///< px that the part can move before the codec encodes it
  /// Half widths, px, of the dead band through which slow motion of the part and of the mark is seen: it
  /// arrives late by up to that, with too small an amplitude.
  double part_play = 0, mark_play = 0;
  double added_sd = 0;   ///< px rms of a coordinate
  double slow_time = 0;  ///< correlation time of what is added, s
  /// Share of the displacement by which the two passes differ, where it is beyond doubt.
  double passes_differ = 0;
};

struct Coder;

/// What to expect of a recording with lossy compression before anything is tracked.
/// For a disc of 30 px radius whose edge has this contrast, grey levels. In such recordings the errors of
/// motion faster than 0.2 px a frame were 0.3 steps over the contrast with prediction between frames (0.26
/// to 0.39; x264, mpeg4), 0.08 with every frame coded by itself (0.06 to 0.10); slow motion is delayed by
/// up to d0 = 0.71 dead_zone step / contrast (vision/coding/coded_errors.h).
struct CodingForecast {
  double error_px = 0;
  double late_px = 0;
  std::string advice;
};

/// Empty if the codec's quantiser steps are unknown.
std::optional<CodingForecast> forecast(const Coder& coder, double contrast);

/// A correlated error: of each coordinate by itself, stationary, with covariance
/// sd^2 exp(-|t - t'|/time) between two frames. It is included in every point's standard deviations.
struct SlowPart {
  std::string from;  ///< its source: "pictures", "halves", "coder"
  double sd = 0;     ///< px, of one coordinate, its mean over the track removed
  double time = 0;   ///< s, the integral of its autocorrelation
};

/// A square tag (ArUco, AprilTag) on the platform, in the first frame.
struct SeenTag {
  std::string dictionary;
  int id = -1;
  double side_px = 0, side_sd_px = 0;  ///< of the black square
};

/// What is known of a track as a whole.
struct TrackSummary : FrameCounts {
  Circle disc;  ///< its edge as seen in the first frame: given or found, px; radius 0 for a rectangle
  double disc_blur = 0;  ///< s, Gaussian sd of its edge with the pixel in it, px; 0 where not measured
  /// Of the edge as seen, px, 0 where not measured.
  double disc_radius_sd = 0;
  /// The outer edge, px: beyond the edge as seen there may be a chamfer that does not show. That of the
  /// edge as seen where none was measured. The common sd is what all recordings of this part share.
  double outer_radius = 0, outer_radius_sd = 0, outer_radius_common_sd = 0;
  double chamfer = 0;          ///< px: its width if known or seen, else the widest that would not show
  bool chamfer_known = false;  ///< given, or seen
  Circle marker;               ///< a round one; radius 0 without
  std::optional<SeenTag> tag;  ///< the marker, if it is one
  /// Where the platform's own texture is the marker: steps of a codec, grey levels, through which it is seen.
  std::optional<double> ground_steps;
  int gate_pixels = 0;            ///< pixels averaged over the lamp, 0 without one
  double gate_clipped_share = 0;  ///< clipped share of them, in the worst frame
  double noise_levels = 0;  ///< picture noise used for sigma, grey levels, the 1/12 of rounding included
  double limit_px = 0;      ///< Cramer-Rao bound of one coordinate, px; of the layered model where it is used
  bool layered = false;     ///< positions come from the layered second pass
  /// Correlated errors of the points, beside each point's own and independent of each other: a mean over
  /// many points does not average them out.
  std::vector<SlowPart> slow;
  double slow_sd() const;    ///< px, of all of them
  double slow_time() const;  ///< s, their mean by variance
  Audit audit;
  std::optional<CodedErrors> coded;  ///< of a lossy recording
  std::vector<PlanStage> plan;
  std::vector<std::string> warnings;
  /// One line for people.
  std::string brief_report() const;
};

struct TrackResult {
  Track track;
  TrackSummary summary;
  std::vector<StageTime> stage_times;  ///< measured, so not the same from run to run
};

}  // namespace tribotrack::vision
