#include "vision/timing/container_timestamps.h"

#include <fmt/core.h>

#include <cmath>
#include <string>

namespace tribotrack::vision {
namespace {

/// Does timestamp k lie within one tick of k / rate?
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

std::string played_at(double rate_hz) {
  return fmt::format("{:.5g} is a playback rate that files carry independently of the camera", rate_hz);
}

/// An uneven rate need not hit a playback rate to be one.
std::optional<double> nearly_playback_rate(double rate_hz) {
  for (double share = -0.02; share <= 0.0201; share += 0.001)
    if (const auto usual = usual_playback_rate(rate_hz * (1 + share))) return usual;
  return std::nullopt;
}

constexpr double kCoarsestForGaps = 0.1;  ///< tick over step
constexpr double kCoarsestForTimes = 0.02;

void judge_uneven(std::span<const std::int64_t> ticks, double tick_s, ContainerTimestamps& stamps) {
  TimeBaseCandidate& candidate = stamps.candidate;
  for (std::size_t k = 1; k < ticks.size(); ++k)
    if (ticks[k] <= ticks[k - 1]) {
      candidate.reason = fmt::format("they are not uniform and do not rise at frame {}", k);
      return;
    }
  std::vector<double> times;
  for (const std::int64_t tick : ticks) times.push_back(static_cast<double>(tick - ticks[0]) * tick_s);
  StampCheck check = check_stamps(times, tick_s);
  candidate.rate_hz = check.rate_hz;
  const double coarseness = tick_s * check.rate_hz;
  if (coarseness > (check.variable ? kCoarsestForTimes : kCoarsestForGaps)) {
    candidate.reason =
        fmt::format("they are not uniform, and ticks of {:.3g} s are too coarse to time frames by", tick_s);
    return;
  }
  stamps.times_s = std::move(times);
  stamps.check = std::move(check);
  if (const auto usual = nearly_playback_rate(candidate.rate_hz)) {
    candidate.reason = "they are not uniform, and " + played_at(*usual);
  } else if (coarseness > kCoarsestForTimes) {
    candidate.reason = fmt::format("ticks of {:.3g} s are too coarse to fix the rate", tick_s);
  } else {
    candidate.accepted = true;
    candidate.reason = stamps.check.variable
                           ? "each frame has its own, and their rate is no usual playback rate"
                           : "uniform but for gaps or changes, and no usual playback rate";
  }
}

}  // namespace

ContainerTimestamps judge_container_timestamps(std::span<const std::int64_t> ticks, double tick_s,
                                               double stated_rate_hz) {
  ContainerTimestamps stamps;
  TimeBaseCandidate& candidate = stamps.candidate;
  candidate.source = "container time stamps";
  if (ticks.size() < 2) {
    candidate.reason = "a single frame has no rate";
    return stamps;
  }
  const double span = static_cast<double>(ticks.back() - ticks.front());
  if (!(span > 0)) {
    candidate.reason = "they do not rise";
    return stamps;
  }
  const double ticks_per_frame = span / static_cast<double>(ticks.size() - 1);
  candidate.rate_hz = 1 / (ticks_per_frame * tick_s);
  const bool stated_fits = stated_rate_hz > 0 && fit_to_one_tick(ticks, 1 / (stated_rate_hz * tick_s));
  if (stated_fits) candidate.rate_hz = stated_rate_hz;

  if (!fit_to_one_tick(ticks, 1 / (candidate.rate_hz * tick_s))) {
    judge_uneven(ticks, tick_s, stamps);
  } else if (const auto usual = usual_playback_rate(candidate.rate_hz)) {
    candidate.reason = played_at(*usual);
  } else if (!stated_fits && !exactly_uniform(ticks) && 1 / span > 1e-4) {
    candidate.reason = fmt::format("ticks of {:.3g} s are too coarse to fix the rate", tick_s);
  } else {
    candidate.accepted = true;
    candidate.reason = "uniform, and no usual playback rate";
  }
  return stamps;
}

std::vector<double> frame_times(const ContainerTimestamps& stamps, const TimeBase& base) {
  if (stamps.times_s.empty() || !base.known()) return {};
  const StampCheck& check = stamps.check;
  const bool gaps_only = !check.variable && check.stretches.size() == 1 && check.strays.empty();
  std::vector<double> times;
  if (gaps_only) {
    std::int64_t place = 0;
    std::size_t gap = 0;
    for (std::size_t k = 0; k < stamps.times_s.size(); ++k, ++place) {
      times.push_back(static_cast<double>(place) / *base.rate_hz);
      if (gap < check.missing.size() && check.missing[gap].after == static_cast<std::int64_t>(k))
        place += check.missing[gap++].count;
    }
  } else if (base.source != user_rate(1).source) {
    for (const double time : stamps.times_s) times.push_back(time * check.rate_hz / *base.rate_hz);
  }
  return times;
}

}  // namespace tribotrack::vision
