#include "fit/gate_timing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "fit/measuring/edge_likelihood.h"
#include "fit/tools/angles.h"
#include "fit/tools/statistics.h"
#include "model/alpha_v.h"

namespace tribotrack::fit {
namespace {

using internal::into_circle;
using internal::turn;

constexpr double kRounding = 0.29;  ///< levels: sd of whole levels, where no noise dithers them

/// Level of a lamp that does not change, and the sd of a single frame about it.
struct Plateau {
  double level = 0, sigma = 0;
  double frames = 0;
};

Plateau plateau_of(const std::vector<double>& levels) {
  Plateau p;
  p.frames = static_cast<double>(levels.size());
  if (levels.empty()) return p;
  const double centre = internal::upper_median(levels);
  std::vector<double> off;
  for (const double l : levels) off.push_back(std::abs(l - centre));
  const double robust = internal::kSdPerMad * internal::upper_median(off);
  double sum = 0, squares = 0, count = 0;
  for (const double l : levels) {
    if (std::abs(l - centre) > 4 * std::max(robust, 0.02)) continue;
    sum += l - centre;
    squares += (l - centre) * (l - centre);
    ++count;
  }
  p.level = centre + sum / count;
  const double scatter = std::sqrt(std::max(0.0, squares / count - sum * sum / (count * count)));
  p.sigma = scatter < 0.01 ? kRounding : scatter;
  return p;
}

/// The gate as a first look shows it.
struct FirstLook {
  double opening = 0, closing = 0;  ///< rad; closing > opening
  double spacing = 0;               ///< the wider of the gaps between frames about the two edges
};

/// Kadane: the consecutive stretch [first, last] with the largest sum of sign * (level - half).
struct Stretch {
  double sum = 0;
  std::size_t first = 0, last = 0;
};

Stretch largest_stretch(const std::vector<std::pair<double, double>>& folded, double half, double sign) {
  Stretch best, current;
  for (std::size_t k = 0; k < folded.size(); ++k) {
    if (current.sum <= 0) current = {0, k, k};
    current.sum += sign * (folded[k].second - half);
    current.last = k;
    if (current.sum > best.sum) best = current;
  }
  return best;
}

FirstLook look(const std::vector<std::pair<double, double>>& folded, double half) {
  const std::size_t n = folded.size();
  // On a circle the pulse, or else the pause, is one piece.
  const Stretch lit = largest_stretch(folded, half, 1), dark = largest_stretch(folded, half, -1);
  double total = 0;
  for (const auto& [phase, level] : folded) total += level - half;
  const bool pulse_in_one_piece = lit.sum >= total + dark.sum;
  const std::size_t first = pulse_in_one_piece ? lit.first : (dark.last + 1) % n;
  const std::size_t last = pulse_in_one_piece ? lit.last : (dark.first + n - 1) % n;
  const auto phase = [&](std::size_t k) { return folded[k % n].first; };
  const double gap_before = into_circle(phase(first) - phase(first + n - 1));
  const double gap_after = into_circle(phase(last + 1) - phase(last));
  const double width = into_circle(phase(last) - phase(first));
  const double opening = phase(first) - 0.5 * gap_before;
  return {opening, opening + 0.5 * gap_before + width + 0.5 * gap_after, std::max(gap_before, gap_after)};
}

struct Levels {
  Plateau off, on;
  double contrast() const { return on.level - off.level; }
};

/// Frames further than `margin` from both edges, by side.
Levels levels_of(const LampRecord& lamp, const std::vector<double>& phase, const FirstLook& gate,
                 double margin) {
  std::vector<double> lit, dark;
  const double width = gate.closing - gate.opening;
  for (std::size_t i = 0; i < phase.size(); ++i) {
    const double since = into_circle(phase[i] - gate.opening);
    if (since > margin && since < width - margin) lit.push_back(lamp.level[i]);
    if (since > width + margin && since < turn - margin) dark.push_back(lamp.level[i]);
  }
  return {plateau_of(dark), plateau_of(lit)};
}

/// The frames that contain information on one edge, relative to `edge`.
std::vector<internal::EdgeFrame> frames_about(double edge, bool opening, double reach, double half_exposure,
                                              double half_interval, const LampRecord& lamp,
                                              const std::vector<double>& phase, const Levels& levels) {
  std::vector<internal::EdgeFrame> frames;
  // With the opening edge below the frame the lamp is on; with the closing edge below it, off.
  const Plateau& below = opening ? levels.on : levels.off;
  const Plateau& above = opening ? levels.off : levels.on;
  for (std::size_t i = 0; i < phase.size(); ++i) {
    const double at = model::wrap_angle(phase[i] - edge);
    if (std::abs(at) > reach) continue;
    internal::EdgeFrame f;
    f.level = lamp.level[i];
    f.level_below = below.level;
    f.level_above = above.level;
    f.sigma_below = below.sigma;
    f.sigma_above = above.sigma;
    const double share = (f.level - levels.off.level) / levels.contrast();
    const double margin = 5 * std::max(below.sigma, above.sigma) / levels.contrast();
    const bool between = share > margin && share < 1 - margin;
    f.only_inside = lamp.clipped || !lamp.exposure;
    double half = lamp.exposure ? half_exposure : half_interval;
    double centre = at;
    if (!lamp.exposure && !between) half = 0;  // only the middle of the exposure is known
    if (lamp.exposure && lamp.clipped && !between) {
      // A saturated lamp may have been lit for a part of it only: not dark means that some of it was.
      centre += opening ? half : -half;
      half = 0;
    }
    f.low = centre - half;
    f.high = centre + half;
    frames.push_back(f);
  }
  return frames;
}

struct Edge {
  Estimate phase;
  double jitter = 0;
  int partly_lit = 0;
};

Edge edge_of(double guess, bool opening, double reach, double half_exposure, double half_interval,
             double cycles, const LampRecord& lamp, const std::vector<double>& phase, const Levels& levels) {
  const auto frames = frames_about(guess, opening, reach, half_exposure, half_interval, lamp, phase, levels);
  // The resolution of one frame at best, over as many as there are.
  const double sigma = std::max(levels.off.sigma, levels.on.sigma) / levels.contrast();
  const double resolution = std::max(1e-7, 0.5 * sigma * std::max(2 * half_exposure, 1e-4) /
                                               std::sqrt(static_cast<double>(frames.size() + 1)));
  const internal::EdgeEstimate found = internal::estimate_edge(frames, reach, std::min(resolution, 1e-3));
  Edge edge;
  edge.phase = {guess + found.edge.value, found.edge.sd};
  edge.jitter = found.jitter;
  // One cycle measures its own edge once, however many frames it has.
  edge.phase.sd = std::max(edge.phase.sd, edge.jitter / std::sqrt(std::max(1.0, cycles)));
  for (const auto& f : frames)
    edge.partly_lit += !f.only_inside && f.low < found.edge.value && f.high > found.edge.value;
  if (edge.partly_lit > 0) {
    // The levels are means of finitely many frames: half-way up, an error of either moves the edge by as
    // much.
    const double by_level = half_exposure / levels.contrast();
    edge.phase.sd = std::hypot(edge.phase.sd,
                               by_level * std::hypot(levels.on.sigma / std::sqrt(1.0 + levels.on.frames),
                                                     levels.off.sigma / std::sqrt(1.0 + levels.off.frames)));
  }
  return edge;
}

}  // namespace

GateMeasurement measure_gate(const LampRecord& lamp, const PhaseClock& clock) {
  const auto none = [](std::string why) { return GateMeasurement{std::nullopt, std::move(why)}; };
  const std::size_t n = lamp.time.size();
  if (n < 20 || lamp.level.size() != n) return none("fewer than 20 frames show the lamp");
  const double w = clock.angular_frequency;
  if (!(w > 0)) return none("the platform's frequency is not known");
  const double cycles = (lamp.time.back() - lamp.time.front()) * w / turn;
  if (cycles < 1) return none("the recording covers less than one cycle");

  std::vector<double> phase(n);
  std::vector<std::pair<double, double>> folded(n);
  for (std::size_t i = 0; i < n; ++i) {
    phase[i] = clock.at(lamp.time[i]);
    folded[i] = {into_circle(phase[i]), lamp.level[i]};
  }
  std::sort(folded.begin(), folded.end());
  const auto [low, high] = std::minmax_element(lamp.level.begin(), lamp.level.end());
  if (!(*high - *low > 3))
    return none("the lamp does not blink: its brightness changes by less than 3 levels");

  const double interval =
      w * (lamp.time.back() - lamp.time.front()) / static_cast<double>(n - 1);  // rad a frame
  const double half_interval = 0.5 * interval;
  const double half_exposure = 0.5 * w * lamp.exposure.value_or(0);
  const FirstLook first = look(folded, 0.5 * (*low + *high));
  const double width = first.closing - first.opening;
  const double longest = std::max(2 * half_exposure, lamp.exposure ? 0.0 : interval);
  if (width < 1.2 * longest || turn - width < 1.2 * longest)
    return none(
        "the pulse, or the pause between pulses, is shorter than an exposure: the lamp shows no edges of its "
        "own");
  const double margin = std::min(1.2 * longest, 0.3 * std::min(width, turn - width));
  const Levels levels = levels_of(lamp, phase, first, margin);
  if (levels.on.frames < 3 || levels.off.frames < 3)
    return none("no frames lie wholly inside the pulse, or wholly outside");
  if (levels.contrast() < 5 * std::max(levels.on.sigma, levels.off.sigma))
    return none("the lamp does not stand out of its noise, or does not blink with the platform's frequency");

  const double reach = std::min(2 * (longest + first.spacing), 0.5 * std::min(width, turn - width));
  const Edge opening =
      edge_of(first.opening, true, reach, half_exposure, half_interval, cycles, lamp, phase, levels);
  const Edge closing =
      edge_of(first.closing, false, reach, half_exposure, half_interval, cycles, lamp, phase, levels);

  GateTiming timing;
  const double clock_variance = clock.phase_sd * clock.phase_sd;
  const double opening_variance = opening.phase.sd * opening.phase.sd;
  timing.phi = {into_circle(opening.phase.value), std::sqrt(opening_variance + clock_variance)};
  timing.dtau = {closing.phase.value - opening.phase.value, std::hypot(opening.phase.sd, closing.phase.sd)};
  timing.covariance = -opening_variance;
  timing.jitter = std::max(opening.jitter, closing.jitter);
  timing.partly_lit = opening.partly_lit + closing.partly_lit;
  const auto box = [](const Edge& e) { return e.partly_lit == 0 ? std::sqrt(12.0) * e.phase.sd : 0; };
  timing.bracket = std::max(box(opening), box(closing));
  timing.cycles = static_cast<int>(cycles);
  timing.off_level = levels.off.level;
  timing.on_level = levels.on.level;
  timing.source = "lamp";
  return {timing, ""};
}

}  // namespace tribotrack::fit
