#include "vision/timing/clock.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr double kJitter = 1e-3;           ///< of a step
constexpr double kRounding = 0.500001;     ///< ticks
constexpr double kFewestTicks = 2;         ///< to a step, for a rounded one to count frames
constexpr double kTicksForTimes = 9.99;    ///< to a step, for stamps to time frames one by one
constexpr double kSingle = 0.95;           ///< share of single steps, where a tick is taken for a slot
constexpr std::size_t kShortest = 3;       ///< steps of a stretch
constexpr double kLongestGap = 1000;       ///< steps; more is no gap but a foreign timestamp
constexpr std::size_t kMostStretches = 8;  ///< more are no changes of a setting but a rate that varies
constexpr std::size_t kMostListed = 5;     ///< findings of a kind that are written out
constexpr double kRateFixed = 1e-4;        ///< relative error of a rate that is used

using Whole = std::vector<std::int64_t>;

/// The slots of stamps; ticks to a slot by least squares, and the least by which all stamps are within a line
/// of about that slope.
struct Slots {
  Whole slots;
  double step = 0, off = 0;
};

/// Half the range of what the stamps differ by from multiples of a step.
double off_by(const Whole& ticks, const Whole& slots, double step) {
  double low = 0, high = 0;
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    const double differs = static_cast<double>(ticks[k] - ticks[0]) - step * static_cast<double>(slots[k]);
    low = std::min(low, differs);
    high = std::max(high, differs);
  }
  return 0.5 * (high - low);
}

/// The least of that, which is convex in the step, or what is no more than rounding.
double least_off(const Whole& ticks, const Whole& slots, double step) {
  double reach = 2 / static_cast<double>(std::max<std::int64_t>(1, slots.back()));
  double least = off_by(ticks, slots, step);
  for (int halving = 0; halving < 20 && least > kRounding; ++halving, reach /= 2)
    for (const double other : {step - reach, step + reach})
      if (const double off = off_by(ticks, slots, other); off < least) {
        least = off;
        step = other;
      }
  return least;
}

Slots on_line(const Whole& ticks, Whole slots) {
  const auto count = static_cast<double>(ticks.size());
  double mean_tick = 0, mean_slot = 0, product = 0, square = 0;
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    mean_tick += static_cast<double>(ticks[k] - ticks[0]) / count;
    mean_slot += static_cast<double>(slots[k]) / count;
  }
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    const double slot = static_cast<double>(slots[k]) - mean_slot;
    product += slot * (static_cast<double>(ticks[k] - ticks[0]) - mean_tick);
    square += slot * slot;
  }
  double step = product / square;
  // Whole multiples of one step leave nothing to least squares but its rounding.
  if (const double whole = std::round(step); off_by(ticks, slots, whole) == 0) step = whole;
  const double off = least_off(ticks, slots, step);
  return {std::move(slots), step, off};
}

Whole counted(std::size_t count) {
  Whole slots(count);
  std::iota(slots.begin(), slots.end(), std::int64_t{0});
  return slots;
}

/// Each frame as many slots after the one before as its step, rounded, is long.
Whole slots_by_steps(const Whole& ticks, double usual) {
  double sum = 0, steps = 0;
  for (std::size_t k = 1; k < ticks.size(); ++k) {
    const auto step = static_cast<double>(ticks[k] - ticks[k - 1]);
    if (std::abs(step - usual) > 0.5 * usual) continue;
    sum += step;
    ++steps;
  }
  Whole slots{0};
  for (std::size_t k = 1; k < ticks.size(); ++k) {
    const double count = static_cast<double>(ticks[k] - ticks[k - 1]) * steps / sum;
    slots.push_back(slots.back() + std::max<std::int64_t>(1, std::llround(std::min(count, 1e9))));
  }
  return slots;
}

/// The slots of stamps that lie on a line, or nothing. `usual` is the median step.
std::optional<Slots> slots_of(const ClockEvidence& evidence, double usual) {
  const Whole& ticks = evidence.ticks;
  const auto off_allowed = [&](double step) {
    return std::max(
        {kRounding, evidence.jitter_s / evidence.tick_s, kJitter * step, std::min(2.0, step / 50)});
  };
  std::optional<Slots> by_ticks;  // as the container counts them
  if (evidence.slots) {
    by_ticks = Slots{ticks, 1, 0};
    for (std::int64_t& slot : by_ticks->slots) slot -= ticks[0];
    if (usual == 1) return by_ticks;
  }
  const Slots even = on_line(ticks, counted(ticks.size()));
  if (even.step > 0 && even.off <= off_allowed(even.step)) return even;
  if (!(usual > 0)) return by_ticks;
  const Slots gaps = on_line(ticks, slots_by_steps(ticks, usual));
  const auto steps = static_cast<double>(ticks.size() - 1);
  double single = 0;
  for (std::size_t k = 1; k < ticks.size(); ++k) {
    const std::int64_t count = gaps.slots[k] - gaps.slots[k - 1];
    if (static_cast<double>(count) > kLongestGap) return by_ticks;
    single += count == 1;
  }
  const bool exact = gaps.off == 0;
  const bool told = gaps.step > kFewestTicks || (exact && gaps.step == kFewestTicks) ||
                    (exact && single >= kSingle * steps);
  if (!told || 2 * single < steps || gaps.off > off_allowed(gaps.step)) return by_ticks;
  return gaps;
}

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

StampCheck check_of_line(const Slots& found, double tick_s) {
  StampCheck check;
  check.rate_hz = 1 / (found.step * tick_s);
  check.stretches = {{0, static_cast<std::int64_t>(found.slots.size()) - 1, check.rate_hz}};
  for (std::size_t k = 1; k < found.slots.size(); ++k)
    if (const std::int64_t count = found.slots[k] - found.slots[k - 1]; count > 1)
      check.missing.push_back({static_cast<std::int64_t>(k) - 1, count - 1});
  check.uniform = check.missing.empty();
  return check;
}

/// Of stamps that lie on no line: the rate changes, or varies, or the clock began anew after a gap.
StampCheck check_of_steps(const ClockEvidence& evidence, double usual) {
  StampCheck check;
  check.uniform = false;
  std::vector<double> steps, off;
  for (std::size_t k = 1; k < evidence.ticks.size(); ++k) {
    steps.push_back(static_cast<double>(evidence.ticks[k] - evidence.ticks[k - 1]) * evidence.tick_s);
    off.push_back(std::abs(steps.back() / (usual * evidence.tick_s) - 1));
  }
  check.jitter = median(off);
  check.stretches = stretches_of(
      steps, std::max(kJitter, (2 * evidence.tick_s + evidence.jitter_s) / (usual * evidence.tick_s)));
  const auto length = [](const SteadyStretch& s) { return s.last - s.first; };
  std::int64_t in_stretches = 0;
  for (const SteadyStretch& s : check.stretches) in_stretches += length(s);
  if (check.stretches.empty() || check.stretches.size() > kMostStretches ||
      2 * in_stretches < static_cast<std::int64_t>(steps.size())) {
    check.stretches.clear();
    check.variable = true;
    check.rate_hz = 1 / (on_line(evidence.ticks, counted(evidence.ticks.size())).step * evidence.tick_s);
    return check;
  }
  check.rate_hz = std::ranges::max_element(check.stretches, {}, length)->rate_hz;
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

std::string played_at(double rate_hz) {
  return fmt::format("{:.5g} is a playback rate that files carry independently of the camera", rate_hz);
}

/// Stamps on a line: is its rate one to use?
void judge_line(const ClockEvidence& evidence, const Slots& found, JudgedStamps& stamps) {
  TimeBaseCandidate& candidate = stamps.candidate;
  const double span = found.step * static_cast<double>(found.slots.back());
  const double stated = evidence.stated_rate_hz;
  const bool stated_fits =
      stated > 0 && off_by(evidence.ticks, found.slots, 1 / (stated * evidence.tick_s)) <= 2 * kRounding;
  if (stated_fits) candidate.rate_hz = stamps.check.rate_hz = stamps.check.stretches[0].rate_hz = stated;
  const auto usual = usual_playback_rate(candidate.rate_hz);
  if (!evidence.by_camera && usual) {
    candidate.reason = played_at(*usual);
  } else if (!evidence.by_camera && !stated_fits && found.off > 0 && !(span > 1 / kRateFixed)) {
    candidate.reason = fmt::format("ticks of {:.3g} s are too coarse to fix the rate", evidence.tick_s);
  } else {
    candidate.accepted = true;
    candidate.reason = evidence.by_camera     ? "rate of the camera's stamps"
                       : stamps.check.uniform ? "uniform, and no usual playback rate"
                                              : "uniform but for gaps, and no usual playback rate";
  }
}

void judge_steps(const ClockEvidence& evidence, JudgedStamps& stamps) {
  TimeBaseCandidate& candidate = stamps.candidate;
  const double ticks_per_step = 1 / (candidate.rate_hz * evidence.tick_s);
  if (ticks_per_step < kTicksForTimes) {
    candidate.reason = fmt::format(
        "they are not uniform, and ticks of {:.3g} s are too coarse to time frames by", evidence.tick_s);
    stamps.check = {};
    return;
  }
  for (const std::int64_t tick : evidence.ticks)
    stamps.times_s.push_back(static_cast<double>(tick - evidence.ticks[0]) * evidence.tick_s);
  // An uneven rate need not hit a playback rate to be one.
  if (const auto usual = usual_playback_rate(candidate.rate_hz, 0.02); usual && !evidence.by_camera) {
    candidate.reason = "they are not uniform, and " + played_at(*usual);
    return;
  }
  candidate.accepted = true;
  candidate.reason = evidence.by_camera ? "rate of the camera's stamps"
                     : stamps.check.variable
                         ? "each frame has its own, and their rate is no usual playback rate"
                         : "uniform but for gaps or changes, and no usual playback rate";
}

}  // namespace

JudgedStamps judge_stamps(const ClockEvidence& evidence) {
  JudgedStamps stamps;
  TimeBaseCandidate& candidate = stamps.candidate;
  candidate.source = evidence.stamps_from;
  const Whole& ticks = evidence.ticks;
  if (ticks.size() < 2) {
    candidate.reason = "a single frame has no rate";
    return stamps;
  }
  const auto [low, high] = std::ranges::minmax(ticks);
  if (ticks.back() <= ticks.front() || static_cast<double>(high) - static_cast<double>(low) > 0x1p62) {
    candidate.reason = "they do not rise, or lie ages apart";
    return stamps;
  }
  std::vector<double> steps;
  std::size_t falls = 0;
  for (std::size_t k = ticks.size() - 1; k > 0; --k) {
    steps.push_back(static_cast<double>(ticks[k] - ticks[k - 1]));
    if (!(steps.back() > 0)) falls = k;
  }
  const double usual = median(steps);
  if (const auto found = slots_of(evidence, usual)) {
    stamps.check = check_of_line(*found, evidence.tick_s);
    candidate.rate_hz = stamps.check.rate_hz;
    stamps.slots = found->slots;
    judge_line(evidence, *found, stamps);
    if (falls == 0)
      for (const std::int64_t tick : ticks)
        stamps.times_s.push_back(static_cast<double>(tick - ticks[0]) * evidence.tick_s);
    return stamps;
  }
  candidate.rate_hz = static_cast<double>(ticks.size() - 1) /
                      (static_cast<double>(ticks.back() - ticks.front()) * evidence.tick_s);
  if (falls > 0) {
    candidate.reason = fmt::format("they are not uniform and do not rise at frame {}", falls);
    return stamps;
  }
  stamps.check = check_of_steps(evidence, usual);
  candidate.rate_hz = stamps.check.rate_hz;
  judge_steps(evidence, stamps);
  return stamps;
}

namespace {

/// What the camera states where its own stamps say another rate is not the rate that the times have.
void reject_what_stamps_deny(const ClockEvidence& evidence, const JudgedStamps& stamps,
                             std::vector<TimeBaseCandidate>& candidates, std::vector<std::string>& notes) {
  constexpr double kNear = 1e-3;
  const auto near = [](double a, double b) { return std::abs(a / b - 1) <= kNear; };
  for (TimeBaseCandidate& said : candidates) {
    if (!said.accepted || said.source == stamps.candidate.source) continue;
    const bool agrees = !stamps.slots.empty()
                            ? off_by(evidence.ticks, stamps.slots, 1 / (said.rate_hz * evidence.tick_s)) <=
                                  std::max(1.0, evidence.jitter_s / evidence.tick_s)
                            : near(stamps.check.rate_hz, said.rate_hz) ||
                                  std::ranges::any_of(stamps.check.stretches, [&](const SteadyStretch& s) {
                                    return near(s.rate_hz, said.rate_hz);
                                  });
    if (agrees) continue;
    said.accepted = false;
    said.reason += fmt::format(", but its time stamps give {:.8g} Hz", stamps.check.rate_hz);
    if (stamps.check.stretches.size() < 2 && !near(stamps.check.rate_hz, said.rate_hz))
      notes.push_back(
          fmt::format("the camera's time stamps give {:.6g} Hz where {:.6g} Hz is stated: each frame has the "
                      "time of its stamp",
                      stamps.check.rate_hz, said.rate_hz));
  }
}

}  // namespace

TimeBase judge_time(const ClockEvidence& evidence, const SourceOptions& options, std::int64_t first_number,
                    std::vector<std::string>& notes) {
  std::vector<TimeBaseCandidate> candidates;
  const bool users = options.frame_rate_hz.has_value();
  if (users) candidates.push_back(user_rate(*options.frame_rate_hz, options.frame_rate_reason));
  candidates.insert(candidates.end(), evidence.camera.begin(), evidence.camera.end());
  if (evidence.ticks.empty()) return choose_time_base(std::move(candidates));

  JudgedStamps stamps = judge_stamps(evidence);
  if (users && evidence.camera.empty())
    require_reason(*options.frame_rate_hz, options.frame_rate_reason, stamps.candidate);
  candidates.push_back(stamps.candidate);
  const bool by_stamps = evidence.by_camera && !stamps.times_s.empty() && !users;
  if (by_stamps) reject_what_stamps_deny(evidence, stamps, candidates, notes);
  if (evidence.by_camera && stamps.times_s.empty() && evidence.ticks.size() > 1)
    notes.push_back("the camera's time stamps are not used: " + stamps.candidate.reason);
  TimeBase base = choose_time_base(std::move(candidates));
  const bool even = stamps.check.uniform && !stamps.slots.empty();
  if (by_stamps) {
    base.stamps_s = std::move(stamps.times_s);
  } else if (base.known() && !even && !stamps.slots.empty()) {
    for (const std::int64_t slot : stamps.slots)
      base.stamps_s.push_back(static_cast<double>(slot) / *base.rate_hz);
  } else if (base.known() && !even) {
    for (const double time : stamps.times_s)
      base.stamps_s.push_back(time * stamps.check.rate_hz / *base.rate_hz);
  }
  if (users && stamps.slots.empty() && stamps.times_s.empty() && evidence.ticks.size() > 1)
    notes.push_back("times count frames: the time stamps do not tell whether some are missing, as " +
                    stamps.candidate.reason);
  for (std::string& finding : findings(stamps.check, first_number)) notes.push_back(std::move(finding));
  if (users && evidence.by_camera && !stamps.times_s.empty())
    notes.push_back("the rate given overrides the camera's own timestamps; leave --fps out to use them");
  else if (users && !base.stamps_s.empty() && std::abs(stamps.check.rate_hz / *base.rate_hz - 1) > kRateFixed)
    notes.push_back(
        fmt::format("the rate given scales the timestamps, which say {:.6g} Hz: gaps and changes stay",
                    stamps.check.rate_hz));
  base.check = std::move(stamps.check);
  return base;
}

std::vector<std::string> findings(const StampCheck& check, std::int64_t first_number) {
  std::vector<std::string> out;
  const auto number = [&](std::int64_t index) { return first_number + index; };
  if (check.variable)
    out.push_back(
        fmt::format("the time between frames varies all along (mean {:.6g} s, half of the steps within "
                    "{:.2g} % of their median): each frame is timed by its own timestamp",
                    1 / check.rate_hz, 100 * check.jitter));
  if (check.stretches.size() > 1) {
    std::string text = "the rate changes within the shot:";
    for (const SteadyStretch& s : check.stretches)
      text += fmt::format(" {:.6g} Hz from image {} to {},", s.rate_hz, number(s.first), number(s.last));
    text.back() = ';';
    out.push_back(text + " each frame is timed by its own timestamp");
  }
  const std::int64_t missing = check.missing_frames();
  for (std::size_t k = 0; k < std::min(kMostListed, check.missing.size()); ++k)
    out.push_back(fmt::format("{} {} missing between image {} and {}, by the timestamps",
                              check.missing[k].count, check.missing[k].count == 1 ? "frame is" : "frames are",
                              number(check.missing[k].after), number(check.missing[k].after + 1)));
  if (check.missing.size() > kMostListed)
    out.push_back(fmt::format("{} frames are missing in {} places in all", missing, check.missing.size()));
  for (std::size_t k = 0; k < std::min(kMostListed, check.strays.size()); ++k)
    out.push_back(
        fmt::format("the timestamp of image {} is far from those of its neighbours: it does not belong to "
                    "the recording; leave it out with --frames",
                    number(check.strays[k])));
  return out;
}

}  // namespace tribotrack::vision
