#include "vision/timing/container_timestamps.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "vision/kernels/median.h"
#include "vision/time_base.h"

namespace tribotrack::vision {
namespace {

constexpr double kTolerance = 1e-3;        ///< of a step
constexpr std::size_t kShortest = 3;       ///< steps of a stretch
constexpr double kLongestGap = 1000;       ///< steps; more is no gap but a foreign timestamp
constexpr std::size_t kMostStretches = 8;  ///< more are no changes of a setting but a rate that varies
constexpr std::size_t kMostListed = 5;     ///< findings of a kind that are written out

/// Groups of at least kShortest consecutive equal steps; what lies between them belongs to none.
std::vector<SteadyStretch> stretches_of(const std::vector<double>& steps, double tolerance) {
  std::vector<SteadyStretch> found;
  for (std::size_t begin = 0; begin < steps.size();) {
    std::size_t end = begin + 1;
    double sum = steps[begin];
    while (end < steps.size() &&
           std::abs(steps[end] / (sum / static_cast<double>(end - begin)) - 1) <= 2 * tolerance)
      sum += steps[end++];
    if (end - begin >= kShortest) {
      const double step = sum / static_cast<double>(end - begin);
      // After a gap the same rate goes on: one stretch.
      if (!found.empty() && std::abs(step * found.back().rate_hz - 1) <= 2 * tolerance)
        found.back().last = static_cast<std::int64_t>(end);
      else
        found.push_back({static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end), 1 / step});
    }
    begin = end;
  }
  return found;
}

}  // namespace

StampCheck check_stamps(std::span<const double> times_s, double tick_s) {
  StampCheck check;
  if (times_s.size() < 2) return check;
  std::vector<double> steps;
  for (std::size_t k = 1; k < times_s.size(); ++k) steps.push_back(times_s[k] - times_s[k - 1]);
  const double usual = median(std::vector(steps));
  const double tolerance = std::max(kTolerance, 2 * tick_s / usual);
  check.rate_hz = 1 / usual;
  std::vector<double> off;
  for (const double step : steps) off.push_back(std::abs(step / usual - 1));
  check.jitter = median(off);
  check.uniform = *std::max_element(off.begin(), off.end()) <= tolerance;
  if (check.uniform) {
    check.stretches = {{0, static_cast<std::int64_t>(steps.size()), check.rate_hz}};
    return check;
  }
  check.stretches = stretches_of(steps, tolerance);
  std::int64_t in_stretches = 0;
  for (const SteadyStretch& s : check.stretches) in_stretches += s.last - s.first;
  if (check.stretches.empty() || check.stretches.size() > kMostStretches ||
      2 * in_stretches < static_cast<std::int64_t>(steps.size())) {
    check.stretches.clear();
    check.variable = true;
    return check;
  }
  // What no stretch explains: gaps and strays, measured in steps of the stretch they lie in or after.
  std::size_t in = 0;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const auto at = static_cast<std::int64_t>(k);
    while (in + 1 < check.stretches.size() && at >= check.stretches[in + 1].first) ++in;
    const double count = steps[k] * check.stretches[in].rate_hz;
    if (std::abs(count - 1) <= 0.5) continue;
    if (count > kLongestGap || count < 0.5)
      check.strays.push_back(at + 1);
    else
      check.missing.push_back({at, static_cast<std::int64_t>(std::llround(count)) - 1});
  }
  return check;
}

std::vector<std::string> findings(const StampCheck& check, std::int64_t first_number) {
  std::vector<std::string> out;
  const auto number = [&](std::int64_t index) { return first_number + index; };
  if (check.variable)
    out.push_back(
        fmt::format("the time between frames varies all along (median {:.6g} s, half of the steps within "
                    "{:.2g} % of it): each frame is timed by its own timestamp",
                    1 / check.rate_hz, 100 * check.jitter));
  if (check.stretches.size() > 1) {
    std::string text = "the rate changes within the shot:";
    for (const SteadyStretch& s : check.stretches)
      text += fmt::format(" {:.6g} Hz from image {} to {},", s.rate_hz, number(s.first), number(s.last));
    text.back() = ';';
    out.push_back(text + " each frame is timed by its own timestamp");
  }
  std::int64_t missing = 0;
  for (const MissingFrames& gap : check.missing) missing += gap.count;
  for (std::size_t k = 0; k < std::min(kMostListed, check.missing.size()); ++k)
    out.push_back(fmt::format("{} {} missing between image {} and {}, by the timestamps",
                              check.missing[k].count, check.missing[k].count == 1 ? "frame is" : "frames are",
                              number(check.missing[k].after), number(check.missing[k].after + 1)));
  if (check.missing.size() > kMostListed)
    out.push_back(fmt::format("{} frames are missing in {} places in all", missing, check.missing.size()));
  for (std::size_t k = 0; k < std::min(kMostListed, check.strays.size()); ++k)
    out.push_back(
        fmt::format("the timestamp of image {} is far from those of its neighbours: it does not belong to "
                    "the recording; "
                    "leave it out with --frames",
                    number(check.strays[k])));
  return out;
}

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
