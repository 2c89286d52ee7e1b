#include "fit/scope_timing.h"

#include <algorithm>
#include <cmath>

#include "fit/tools/angles.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/statistics.h"
#include "model/alpha_v.h"

namespace tribotrack::fit {
namespace {

using internal::into_circle;
using internal::number;
using internal::turn;

/// Low and high level of a two-level signal: the quantiles are its plateaus, whatever its duty.
struct Swing {
  double low = 0, high = 0;
};

Swing swing_of(std::vector<double> values, double quantile) {
  const auto at = [&](double q) {
    const auto k = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + k, values.end());
    return values[static_cast<std::size_t>(k)];
  };
  return {at(quantile), at(1 - quantile)};
}

struct Crossing {
  double sample = 0;  ///< fractional index
  bool rising = true;
};

/// Crossings of `level`; the signal must leave a band of +- hysteresis before the next one counts. The
/// crossing is where the last stretch inside the band passes the level.
std::vector<Crossing> crossings(const std::vector<double>& v, double level, double hysteresis) {
  std::vector<Crossing> found;
  int side = 0;  // -1 below the band, +1 above it, 0 not yet known
  double last_up = -1, last_down = -1;
  for (std::size_t i = 1; i < v.size(); ++i) {
    const double a = v[i - 1] - level, b = v[i] - level;
    if (a < 0 && b >= 0 && last_up < 0) last_up = static_cast<double>(i - 1) + a / (a - b);
    if (a >= 0 && b < 0 && last_down < 0) last_down = static_cast<double>(i - 1) + a / (a - b);
    const int now = b > hysteresis ? 1 : b < -hysteresis ? -1 : 0;
    if (now == 0) continue;
    if (side == -1 && now == 1 && last_up >= 0) found.push_back({last_up, true});
    if (side == 1 && now == -1 && last_down >= 0) found.push_back({last_down, false});
    side = now;
    last_up = last_down = -1;
  }
  return found;
}

/// Mean of |v - median| over one carrier period (a whole number of samples and the fraction at the end),
/// centred: entry i belongs to sample i.
std::vector<double> envelope_of(const std::vector<double>& v, double period_samples) {
  const double zero = internal::upper_median(v);
  std::vector<double> sum(v.size() + 1, 0);
  for (std::size_t i = 0; i < v.size(); ++i) sum[i + 1] = sum[i] + std::abs(v[i] - zero);
  const auto until = [&](double place) {  // integral from the first sample to a fractional place
    const double inside = std::clamp(place, 0.0, static_cast<double>(v.size()));
    const auto whole = std::min(static_cast<std::size_t>(inside), v.size() - 1);
    return sum[whole] + (inside - static_cast<double>(whole)) * (sum[whole + 1] - sum[whole]);
  };
  std::vector<double> envelope(v.size());
  for (std::size_t i = 0; i < v.size(); ++i) {
    const double centre = static_cast<double>(i) + 0.5;
    envelope[i] =
        (until(centre + 0.5 * period_samples) - until(centre - 0.5 * period_samples)) / period_samples;
  }
  return envelope;
}

/// Share of a signal's alternating power that lies at the carrier, over stretches of four carrier periods:
/// bursts need not be of one phase.
double carrier_share(const std::vector<double>& v, double period_samples) {
  const auto stretch = static_cast<std::size_t>(std::lround(4 * period_samples));
  const double per_sample = turn / period_samples, n = static_cast<double>(stretch);
  double at_carrier = 0, all = 0;
  for (std::size_t begin = 0; begin + stretch <= v.size(); begin += stretch) {
    double mean = 0, squares = 0, in_phase = 0, across = 0;
    for (std::size_t i = begin; i < begin + stretch; ++i) mean += v[i] / n;
    for (std::size_t i = begin; i < begin + stretch; ++i) {
      const double off = v[i] - mean, phase = per_sample * static_cast<double>(i - begin);
      squares += off * off;
      in_phase += off * std::cos(phase);
      across += off * std::sin(phase);
    }
    at_carrier += 2 / n * (in_phase * in_phase + across * across);
    all += squares;
  }
  return all > 0 ? at_carrier / all : 0;
}

/// The carrier must be on the actuator's channel and not on the sensor's.
void require_carrier(const ScopeTrace& trace, const ScopeOptions& options, double period_samples) {
  constexpr double kCarries = 0.5, kCarriesNone = 0.2;
  const double actuator = carrier_share(trace.actuator, period_samples);
  if (actuator > kCarriesNone) return;
  if (carrier_share(trace.sensor, period_samples) > kCarries)
    throw DataError(
        "the carrier is on the sensor's channel and not on the actuator's: the channels are swapped");
  throw DataError("the actuator's channel holds no carrier of carrier_hz = " + number(options.carrier_hz, 6) +
                  " Hz: correct that, or name the right channel");
}

struct MeanPhase {
  double value = 0, scatter = 0;
  std::size_t count = 0;
  double variance() const { return scatter * scatter / static_cast<double>(count); }
};

MeanPhase mean_phase(const std::vector<double>& times, const PhaseClock& clock) {
  MeanPhase mean;
  mean.count = times.size();
  double x = 0, y = 0;
  for (const double t : times) {
    x += std::cos(clock.at(t));
    y += std::sin(clock.at(t));
  }
  mean.value = std::atan2(y, x);
  double squares = 0, sum = 0;
  for (const double t : times) {
    const double off = model::wrap_angle(clock.at(t) - mean.value);
    sum += off;
    squares += off * off;
  }
  const auto n = static_cast<double>(times.size());
  mean.value += sum / n;
  // One burst shows no scatter: then it is as uncertain as it is of being typical.
  mean.scatter = times.size() > 1 ? std::sqrt(std::max(0.0, squares - sum * sum / n) / (n - 1)) : 0.01;
  return mean;
}

/// Times of the rises through half the height, in samples.
std::vector<double> rises_of(const std::vector<double>& volts, const Swing& swing) {
  std::vector<double> rises;
  const double height = swing.high - swing.low;
  if (height > 0)
    for (const Crossing& c : crossings(volts, swing.low + 0.5 * height, 0.1 * height))
      if (c.rising) rises.push_back(c.sample);
  return rises;
}

}  // namespace

ScopeEvents find_scope_events(const ScopeTrace& trace, const ScopeOptions& options) {
  ScopeEvents events;
  const auto time = [&](double sample) { return trace.start + sample * trace.increment; };
  if (!trace.sensor.empty()) {
    // A pulse may last a hundredth of the turn: its height is that of the extremes.
    for (const double rise : rises_of(trace.sensor, swing_of(trace.sensor, 0.002)))
      events.pulses.push_back(time(rise) - options.sensor_delay);
    if (events.pulses.size() < 3)
      throw DataError("the sensor's channel shows fewer than three pulses: is it the right channel?");
  }
  if (!trace.actuator.empty()) {
    const double period = 1 / (options.carrier_hz * trace.increment);
    if (period < 4)
      throw DataError(
          "the actuator's channel has fewer than four samples to a carrier period: record at a "
          "higher sample rate, or correct carrier_hz");
    require_carrier(trace, options, period);
    const std::vector<double> envelope = envelope_of(trace.actuator, period);
    const Swing swing = swing_of(envelope, 0.02);
    const double height = swing.high - swing.low;
    if (height > 0)
      for (const Crossing& c : crossings(envelope, swing.low + 0.5 * height, 0.2 * height))
        (c.rising ? events.openings : events.closings).push_back(time(c.sample));
    if (events.openings.empty() || events.closings.empty())
      throw DataError("the actuator's channel shows no burst: is it the right channel?");
  }
  return events;
}

std::optional<SensorClock> sensor_clock(const ScopeEvents& events, const ScopeOptions& options) {
  const std::size_t n = events.pulses.size();
  if (n < 3) return std::nullopt;
  std::vector<double> gaps;
  for (std::size_t i = 1; i < n; ++i) gaps.push_back(events.pulses[i] - events.pulses[i - 1]);
  const double gap = internal::upper_median(gaps);
  // Turns counted by whole gaps, so that a missed pulse costs one pulse and no phase.
  std::vector<double> turns(n, 0);
  for (std::size_t i = 1; i < n; ++i)
    turns[i] = turns[i - 1] + std::max(1.0, std::round((events.pulses[i] - events.pulses[i - 1]) / gap));
  const auto line = internal::line_through<double>(turns, events.pulses);
  const double period = line.slope;
  double squares = 0;
  for (std::size_t i = 0; i < n; ++i) squares += std::pow(events.pulses[i] - line.at(turns[i]), 2);
  SensorClock result;
  result.scatter = std::sqrt(squares / static_cast<double>(n - 2));
  const double w = turn / period;
  result.angular_frequency = {w, w * result.scatter / std::sqrt(line.square) / period};
  result.clock.angular_frequency = w;
  result.clock.phase_at_zero = std::remainder(turn * line.mean - w * line.middle, turn);
  result.clock.phase_sd =
      w * std::hypot(result.scatter / std::sqrt(static_cast<double>(n)), options.sensor_delay_sd);
  return result;
}

GateMeasurement gate_from_scope(const ScopeEvents& events, const PhaseClock& clock, double tie_sd) {
  constexpr double kSteady = 0.1;  // rad: a gate that is triggered by the platform jitters by far less
  if (events.openings.empty() || events.closings.empty()) return {std::nullopt, "the trace shows no burst"};
  if (!(clock.angular_frequency > 0)) return {std::nullopt, "the platform's frequency is not known"};
  const MeanPhase opening = mean_phase(events.openings, clock), closing = mean_phase(events.closings, clock);
  GateTiming timing;
  const double tie = std::hypot(clock.phase_sd, clock.angular_frequency * tie_sd);
  timing.phi = {into_circle(opening.value), std::sqrt(opening.variance() + tie * tie)};
  timing.dtau = {into_circle(closing.value - opening.value),
                 std::sqrt(opening.variance() + closing.variance())};
  timing.covariance = -opening.variance();
  timing.jitter = std::max(opening.scatter, closing.scatter);
  if (timing.jitter > kSteady)
    return {std::nullopt, "the bursts' edges scatter by " + number(timing.jitter, 2) +
                              " rad from turn to turn: they do not follow this platform"};
  timing.cycles = static_cast<int>(events.openings.size());
  timing.source = "scope";
  return {timing, ""};
}

}  // namespace tribotrack::fit
