#include "vision/container_stamps.h"

#include <cmath>
#include <cstdio>

namespace tribotrack::vision {
namespace {

/// Does stamp k lie within one tick of k / rate?
bool fit_to_one_tick(std::span<const std::int64_t> ticks, double ticks_per_frame) {
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    const double expected = static_cast<double>(ticks[0]) + static_cast<double>(k) * ticks_per_frame;
    if (std::abs(static_cast<double>(ticks[k]) - expected) > 1.0 + 1e-9 * std::abs(expected)) return false;
  }
  return true;
}

bool exactly_uniform(std::span<const std::int64_t> ticks) {
  for (std::size_t k = 2; k < ticks.size(); ++k)
    if (ticks[k] - ticks[k - 1] != ticks[1] - ticks[0]) return false;
  return true;
}

}  // namespace

TimeBaseCandidate judge_container_stamps(std::span<const std::int64_t> ticks, double tick_s,
                                         double stated_rate_hz) {
  TimeBaseCandidate candidate{"container time stamps", 0, false, ""};
  if (ticks.size() < 2) {
    candidate.reason = "a single frame has no rate";
    return candidate;
  }
  const double span = static_cast<double>(ticks.back() - ticks.front());
  if (!(span > 0)) {
    candidate.reason = "they do not rise";
    return candidate;
  }
  const double ticks_per_frame = span / static_cast<double>(ticks.size() - 1);
  candidate.rate_hz = 1 / (ticks_per_frame * tick_s);
  const bool stated_fits = stated_rate_hz > 0 && fit_to_one_tick(ticks, 1 / (stated_rate_hz * tick_s));
  if (stated_fits) candidate.rate_hz = stated_rate_hz;

  char text[160];
  if (const auto usual = usual_playback_rate(candidate.rate_hz)) {
    std::snprintf(text, sizeof text,
                  "%.5g is a playback rate that files carry whatever the camera recorded at", *usual);
  } else if (!fit_to_one_tick(ticks, 1 / (candidate.rate_hz * tick_s))) {
    std::snprintf(text, sizeof text, "they are not uniform");
  } else if (!stated_fits && !exactly_uniform(ticks) && 1 / span > 1e-4) {
    std::snprintf(text, sizeof text, "ticks of %.3g s are too coarse to tell the rate", tick_s);
  } else {
    candidate.accepted = true;
    std::snprintf(text, sizeof text, "uniform, and no usual playback rate");
  }
  candidate.reason = text;
  return candidate;
}

}  // namespace tribotrack::vision
