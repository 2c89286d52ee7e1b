// Rendered recordings for the benchmarks.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "vision/frame_source.h"
#include "vision/synthesis/noise.h"

namespace tribotrack::bench {

/// A picture as an 8-bit camera records it: white noise of `noise` grey levels, then rounding and clipping.
inline vision::Picture recorded(const vision::Picture& exact, double noise, std::uint64_t frame) {
  const vision::CounterRandom random(20210, frame);
  vision::Picture out = exact;
  std::uint64_t counter = 0;
  for (float& level : out.levels())
    level =
        std::clamp(std::round(level + static_cast<float>(noise) * random.gaussian(counter++)), 0.0F, 255.0F);
  return out;
}

/// Every benchmark's recording runs at this frame rate, Hz.
inline constexpr double kFrameRate = 1000;

}  // namespace tribotrack::bench
