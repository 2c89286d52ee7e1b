// What the time stamps of a video container prove about the capture rate.
#pragma once

#include <cstdint>
#include <span>

#include "vision/time_base.h"

namespace tribotrack::vision {

/// The stamps of all frames in the order shown, in ticks of tick_s. They are believed when they are uniform
/// to one tick, tell the rate to 1e-4 (from their span, or from stated_rate_hz, the container's own field, 0
/// where absent, which they must then fit to one tick), and the rate is not a usual playback rate.
TimeBaseCandidate judge_container_stamps(std::span<const std::int64_t> ticks, double tick_s,
                                         double stated_rate_hz);

}  // namespace tribotrack::vision
