// What the timestamps of a video container show of the capture rate.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "vision/time_base.h"

namespace tribotrack::vision {

/// The timestamps of a container's frames, judged.
struct ContainerTimestamps {
  TimeBaseCandidate candidate;
  /// Seconds since the first frame by the container's clock, where the frames are not evenly spaced and its
  /// ticks are fine enough to time them; else empty. A container made for slow playback runs slower than the
  /// camera did: see frame_times.
  std::vector<double> times_s;
  StampCheck check;  ///< of times_s
};

/// The timestamps of all frames in the order shown, in ticks of tick_s. Even ones (to one tick) are used when
/// they fix the rate to 1e-4 (from their span, or from stated_rate_hz, the container's own field, 0 where
/// absent, which they must then fit to one tick) and the rate is not a usual playback rate. Uneven ones are
/// used, frame by frame, when their ticks are fine (a fiftieth of a step) and the median step is not that
/// of a playback rate to 2 %.
ContainerTimestamps judge_container_timestamps(std::span<const std::int64_t> ticks, double tick_s,
                                               double stated_rate_hz);

/// The frames' times at the rate that was accepted, where the container's stamps are uneven; empty where time
/// is frame / rate. Gaps count at any rate. Steps that vary are taken from the stamps, stretched to the rate
/// accepted, unless that is given by the user, which means even steps.
std::vector<double> frame_times(const ContainerTimestamps& stamps, const TimeBase& base);

}  // namespace tribotrack::vision
