// The one judge of a recording's times, whatever its format: header, sidecar, stamps, --fps, gaps.
//
// Stamps t_k, whole ticks of a clock, are those of frames at even times where t_k = a + d n_k to a tick for
// whole rising n_k, the frames' slots. d is found by least squares over all stamps: a count over a span less
// its gaps. A slot without a frame is a frame that is missing.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "vision/frame_source.h"
#include "vision/time_base.h"

namespace tribotrack::vision {

/// What a recording tells of its frames' times.
struct ClockEvidence {
  /// What the camera says: header, sidecar, capture tag; the most trusted first.
  std::vector<TimeBaseCandidate> camera;
  std::string stamps_from = "container time stamps";
  std::vector<std::int64_t> ticks;  ///< of each frame in the order shown; empty where there are no stamps
  double tick_s = 0;
  double jitter_s = 0;        ///< what a stamp may be off by, beyond its tick
  double stated_rate_hz = 0;  ///< of the stamps, by the container; 0: nothing
  bool slots = false;         ///< a tick counts for a frame, whether a picture lies there or not (AVI)
  bool by_camera = false;     ///< stamped by the camera's own clock: real time, never that of playback
};

/// The stamps by themselves.
struct JudgedStamps {
  TimeBaseCandidate candidate;
  StampCheck check;
  std::vector<std::int64_t> slots;  ///< of each frame, 0 the first, where they lie on the line above
  std::vector<double> times_s;      ///< since the first, where they time frames; else empty
};

/// Even stamps are believed when they fix the rate to 1e-4 (by their span, as whole multiples of one step, or
/// as the container states it) and it is no usual playback rate. Others are believed frame by frame when
/// a step has ten ticks and their mean rate is not within 2 % of one of playback.
JudgedStamps judge_stamps(const ClockEvidence& evidence);

/// The rate is the user's, else the camera's, else that of the stamps. Stamps of the camera's own clock time
/// the frames unless the user gives a rate; others count slots at the rate accepted, or are stretched to
/// it: no rate erases their gaps. What a user should know goes to `notes`. Throws InputError for a
/// rate given that is but the one of playback, see require_reason.
TimeBase judge_time(const ClockEvidence& evidence, const SourceOptions& options, std::int64_t first_number,
                    std::vector<std::string>& notes);

}  // namespace tribotrack::vision
