#include "fit/gate_timing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fit/tools/angles.h"
#include "fit/tools/statistics.h"
#include "model/alpha_v.h"

namespace tribotrack::fit {
namespace {

using internal::into_circle;
using internal::turn;

// The likelihood of one edge, from frames that were lit before and dark after it or the reverse.

/// One frame near an edge, in phases relative to a first guess of the edge. With the edge at or below `low`
/// the frame's mean level is `level_below`, at or above `high` it is `level_above`, linear between.
struct EdgeFrame {
  double low = 0, high = 0;  ///< rad
  double level = 0;
  double level_below = 0, level_above = 0;
  double sigma_below = 1, sigma_above = 1;  ///< of the level
  /// Brightness between the two levels shows only that the edge is inside (a saturated lamp, an unknown
  /// exposure).
  bool only_inside = false;
};

struct Edge {
  Estimate phase;      ///< rad
  double jitter = 0;   ///< rad rms
  int partly_lit = 0;  ///< frames
};

constexpr double kStray = 1e-4;    ///< probability that a frame means nothing
constexpr double kJitterGain = 3;  ///< log-likelihood that a jitter has to be worth

double density(double x, double mean, double sigma) {
  const double z = (x - mean) / sigma;
  return std::exp(-0.5 * z * z) / (sigma * std::sqrt(2 * std::numbers::pi));
}

/// P(a < N(0, 1) < b), a <= b.
double between(double a, double b) {
  if (a > 0) return between(-b, -a);  // the smaller tails keep their digits
  return 0.5 * (std::erfc(-b / std::numbers::sqrt2) - std::erfc(-a / std::numbers::sqrt2));
}

/// Likelihood of one frame's level for a mean edge e that jitters by tau: the frame's own likelihood L(e'),
/// constant, then a piece that is normal in e', then constant, convolved with N(e' - e; tau).
double frame_likelihood(const EdgeFrame& f, double e, double tau) {
  const double contrast = std::abs(f.level_above - f.level_below);
  const double below = density(f.level, f.level_below, f.sigma_below);
  const double above = density(f.level, f.level_above, f.sigma_above);
  const double width = f.high - f.low;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto share_within = [&](double from, double to) {
    if (tau > 0) return between((from - e) / tau, (to - e) / tau);
    return e >= from && e < to ? 1.0 : 0.0;
  };
  double sum = below * share_within(-infinity, f.low) + above * share_within(f.high, infinity);
  if (width > 0) {
    if (f.only_inside) {
      sum += share_within(f.low, f.high) / contrast;
    } else {
      // Level = level_below + slope (e' - low): the normal density of the level is one of e' about `centre`.
      const double slope = (f.level_above - f.level_below) / width;
      const double share = std::clamp((f.level - f.level_below) / (f.level_above - f.level_below), 0.0, 1.0);
      const double sigma =
          std::sqrt((1 - share) * f.sigma_below * f.sigma_below + share * f.sigma_above * f.sigma_above);
      const double centre = f.low + (f.level - f.level_below) / slope;
      const double spread = sigma / std::abs(slope);
      if (tau > 0) {
        const double both = std::hypot(spread, tau);
        const double middle = (centre * tau * tau + e * spread * spread) / (both * both);
        const double narrow = spread * tau / both;
        sum += density(e, centre, both) / std::abs(slope) *
               between((f.low - middle) / narrow, (f.high - middle) / narrow);
      } else if (e >= f.low && e < f.high) {
        sum += density(e, centre, spread) / std::abs(slope);
      }
    }
  }
  return (1 - kStray) * sum + kStray / contrast;
}

/// The log-likelihood over a range of edges: frames that contribute the same to all of it are summed once.
class LogLikelihood {
 public:
  LogLikelihood(const std::vector<EdgeFrame>& frames, double from, double to, double tau) : tau_(tau) {
    const double margin = 9 * tau;
    for (const EdgeFrame& f : frames) {
      if (f.high < from - margin)
        common_ += std::log(frame_likelihood(f, to + margin, 0));
      else if (f.low > to + margin)
        common_ += std::log(frame_likelihood(f, from - margin, 0));
      else
        frames_.push_back(f);
    }
  }
  double operator()(double edge) const {
    double sum = common_;
    for (const EdgeFrame& f : frames_) sum += std::log(frame_likelihood(f, edge, tau_));
    return sum;
  }

 private:
  std::vector<EdgeFrame> frames_;
  double tau_;
  double common_ = 0;
};

struct Moments {
  Estimate edge;
  double log_evidence = 0;
};

/// Mean and sd within `reach` of `centre`, by the midpoint rule in a window that closes about what is likely.
/// As long as its cells are wider than that they are looked at through a blur of their width.
Moments integrate(const std::vector<EdgeFrame>& frames, double centre, double reach, double tau) {
  constexpr int kRough = 100, kFine = 400, kMostRounds = 12;
  constexpr double kWindow = 7, kWide = 0.5;  // sd to either side; of a window that need not close further
  const auto moments = [&](int points, bool blurred) {
    const double cell = 2 * reach / points, from = centre - reach;
    const LogLikelihood likelihood(frames, from, centre + reach, blurred ? std::max(tau, cell) : tau);
    std::vector<double> log_values;
    for (int k = 0; k < points; ++k) log_values.push_back(likelihood(from + cell * (k + 0.5)));
    const double most = *std::max_element(log_values.begin(), log_values.end());
    double weight = 0, first = 0, second = 0;
    for (int k = 0; k < points; ++k) {
      const double p = std::exp(log_values[static_cast<std::size_t>(k)] - most),
                   at = cell * (k + 0.5) - reach;
      weight += p;
      first += p * at;
      second += p * at * at;
    }
    const double mean = first / weight;
    // Each point stands for its cell: its width belongs to the sum.
    const double variance = std::max(0.0, second / weight - mean * mean) + cell * cell / 12;
    return Moments{{centre + mean, std::sqrt(variance)}, most + std::log(weight * cell)};
  };
  for (int round = 0; round < kMostRounds; ++round) {
    const Estimate found = moments(kRough, true).edge;
    if (kWindow * found.sd > kWide * reach) break;
    centre = found.value;
    reach = kWindow * found.sd;
  }
  return moments(kFine, false);
}

/// The edge less the guess, under a flat prior and by quadrature. `reach`: the edge lies within
/// +- reach of the guess, rad. `resolution`: a jitter or spacing below this does not matter, rad.
Edge estimate_edge(const std::vector<EdgeFrame>& frames, double reach, double resolution) {
  const Moments still = integrate(frames, 0, reach, 0);

  // Jitter, where it is worth its while.
  Edge best{still.edge};
  double best_evidence = still.log_evidence + kJitterGain;
  double most = still.log_evidence;
  const auto attempt = [&](double tau) {
    const Moments moved = integrate(frames, 0, reach, tau);
    if (moved.log_evidence > best_evidence) {
      best_evidence = moved.log_evidence;
      best = {moved.edge, tau};
    }
    most = std::max(most, moved.log_evidence);
    return moved.log_evidence > most - 25;
  };
  for (double tau = 2 * resolution; tau < 0.5 * reach && attempt(tau); tau *= 2) {
  }
  if (const double tau = best.jitter; tau > 0)
    for (const double factor : {0.6, 0.77, 1.3, 1.6}) attempt(tau * factor);
  return best;
}

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
std::vector<EdgeFrame> frames_about(double edge, bool opening, double reach, double half_exposure,
                                    double half_interval, const LampRecord& lamp,
                                    const std::vector<double>& phase, const Levels& levels) {
  std::vector<EdgeFrame> frames;
  // With the opening edge below the frame the lamp is on; with the closing edge below it, off.
  const Plateau& below = opening ? levels.on : levels.off;
  const Plateau& above = opening ? levels.off : levels.on;
  for (std::size_t i = 0; i < phase.size(); ++i) {
    const double at = model::wrap_angle(phase[i] - edge);
    if (std::abs(at) > reach) continue;
    EdgeFrame f;
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

Edge edge_of(double guess, bool opening, double reach, double half_exposure, double half_interval,
             double cycles, const LampRecord& lamp, const std::vector<double>& phase, const Levels& levels) {
  const auto frames = frames_about(guess, opening, reach, half_exposure, half_interval, lamp, phase, levels);
  // The resolution of one frame at best, over as many as there are.
  const double sigma = std::max(levels.off.sigma, levels.on.sigma) / levels.contrast();
  const double resolution = std::max(1e-7, 0.5 * sigma * std::max(2 * half_exposure, 1e-4) /
                                               std::sqrt(static_cast<double>(frames.size() + 1)));
  Edge edge = estimate_edge(frames, reach, std::min(resolution, 1e-3));
  // One cycle measures its own edge once, however many frames it has.
  edge.phase.sd = std::max(edge.phase.sd, edge.jitter / std::sqrt(std::max(1.0, cycles)));
  for (const auto& f : frames)
    edge.partly_lit += !f.only_inside && f.low < edge.phase.value && f.high > edge.phase.value;
  edge.phase.value += guess;
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
