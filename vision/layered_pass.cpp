#include "vision/layered_pass.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include "vision/layered_ground_crossed.h"
#include "vision/layered_learning.h"
#include "vision/layered_lighting.h"
#include "vision/window.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kEarly = 32;        ///< windows of most sweeps
constexpr int kContext = 6;               ///< px kept beyond the disc's pictures
constexpr double kGroundPixels = 4e6;     ///< of all frames the platform's picture is averaged from
constexpr double kGroundFrames = 40;      ///< and no fewer frames than these
constexpr std::size_t kFewest = 12;       ///< frames to learn from
constexpr double kEnoughSpread = 0.5;     ///< of the windows wanted: else any frame will do
constexpr double kGroundBytes = 52;       ///< per px: the platform's pictures, those of a moment included
constexpr std::size_t kUsualFrames = 15;  ///< that tell what a place usually shows
constexpr double kHeldSd = 5;             ///< what is further off crosses the ground
constexpr double kLeastHeld = 0.7;        ///< of what is uncovered: else it moves
constexpr double kRestless = 2;           ///< ground variance in time over the noise's: it moves
constexpr double kBentShare = 0.1;        ///< of the windows: less is chance, or something that crosses
constexpr int kLightRounds = 16;
constexpr double kLightSettled = 0.05;  ///< of the standard deviation: windows that move less have settled
constexpr double kMostExcess = 64;     ///< times the first pass's, in variance
constexpr double kTurnVisible = 0.15;  ///< px at the rim: less rotation over the recording is none

Picture cut(const Picture& picture, const Rect& from, const Rect& part) {
  Picture out(part.width, part.height);
  for (int y = 0; y < part.height; ++y)
    std::copy_n(picture.row(part.y - from.y + y).begin() + (part.x - from.x), part.width, out.row(y).begin());
  return out;
}

bool turns(const std::vector<FirstPassFrame>& frames, const LayeredOptions& options) {
  if (!options.turning) return false;
  double low = frames.front().theta;
  double high = low;
  for (const FirstPassFrame& f : frames) {
    low = std::min(low, f.theta);
    high = std::max(high, f.theta);
  }
  return (high - low) * options.disc.radius > kTurnVisible;
}

/// What is read of every kept frame: the disc's path with a margin.
Rect swath(const std::vector<FirstPassFrame>& frames, double reach, const Rect& bounds) {
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9, away = 0;
  for (const FirstPassFrame& f : frames) {
    x0 = std::min(x0, f.centre.x);
    x1 = std::max(x1, f.centre.x);
    y0 = std::min(y0, f.centre.y);
    y1 = std::max(y1, f.centre.y);
    away = std::max(away, std::hypot(f.ground.x, f.ground.y));
  }
  const double margin = reach + 2 * away + 4;
  return touched_pixels(x0 - margin, y0 - margin, x1 + margin, y1 + margin, bounds);
}

/// Places in `frames` of those to learn from, `most` at most.
std::vector<std::size_t> choose_windows(const std::vector<FirstPassFrame>& frames, std::size_t most,
                                        const LayeredOptions& options) {
  std::vector<std::size_t> spread, chosen;
  for (std::size_t k = 0; k < frames.size(); ++k)
    if (is_learning_frame(frames[k].index - options.first_index, options.total)) spread.push_back(k);
  if (static_cast<double>(spread.size()) < kEnoughSpread * static_cast<double>(most)) {
    spread.resize(frames.size());
    std::iota(spread.begin(), spread.end(), std::size_t{0});
  }
  const std::size_t count = std::min(most, spread.size());
  for (std::size_t k = 0; k < count; ++k) chosen.push_back(spread[k * (spread.size() - 1) / (count - 1)]);
  return chosen;
}

std::vector<Point> centres(std::span<const KeptWindow> windows) {
  std::vector<Point> out;
  for (const KeptWindow& w : windows) out.push_back(w.state.centre);
  return out;
}

/// Px rms per coordinate, a move of all together not counted.
double moved(const std::vector<Point>& from, const std::vector<Point>& to) {
  double square = 0;
  Point sum;
  for (std::size_t k = 0; k < to.size(); ++k) {
    const double x = to[k].x - from[k].x, y = to[k].y - from[k].y;
    square += x * x + y * y;
    sum.x += x;
    sum.y += y;
  }
  const auto n = static_cast<double>(to.size());
  return std::sqrt(std::max(0.0, (square - (sum.x * sum.x + sum.y * sum.y) / n) / (2 * n)));
}

}  // namespace

bool is_learning_frame(std::int64_t place, std::int64_t total) {
  if (total <= kLearningFrames) return true;
  const std::int64_t last = total - 1, parts = kLearningFrames - 1;
  const std::int64_t next = (place * parts + last - 1) / last;  // the first that does not lie before it
  return next * last / parts == place;
}

double layered_reach(double radius, double blur) {
  return LayeredDisc::half_of(radius, blur) + kContext;
}

LayeredResult layered_pass(FrameSource& source, const std::vector<FirstPassFrame>& frames,
                           const LayeredOptions& options) {
  LayeredResult out;
  if (frames.size() < kFewest) {
    out.why_not = "too few frames to learn the layers from";
    return out;
  }
  LayeredDisc disc(options.disc.radius, options.blur, turns(frames, options));
  const double reach = layered_reach(options.disc.radius, options.blur);
  const Rect region = swath(frames, reach, source.bounds());

  // Keep windows, average the ground.
  const double window_bytes =
      4 * (std::pow(2 * reach + 2, 2) + std::pow(2 * (reach + QuinticSpline::kPad) + 2, 2));
  const double area = static_cast<double>(region.width) * region.height;
  // The platform's pictures and a turning disc's live beside the windows.
  const double room =
      options.max_kept_bytes - kGroundBytes * area - (disc.turning() ? LayeredDisc::kTurningBytes : 0);
  const auto chosen = choose_windows(
      frames,
      static_cast<std::size_t>(std::max(16.0, std::min<double>(options.max_windows, room / window_bytes))),
      options);
  const std::size_t windows = chosen.size();
  const auto ground_stride = static_cast<std::size_t>(
      std::max(1.0, std::ceil(static_cast<double>(windows) / std::max(kGroundFrames, kGroundPixels / area))));
  GroundPicture ground(region);
  std::vector<KeptWindow> kept;
  Picture frame, wide;
  for (std::size_t k = 0; k < windows; ++k) {
    const FirstPassFrame& f = frames[chosen[k]];
    const Rect about = window_about(f.centre, reach, source.bounds());
    const bool whole = k % ground_stride == 0;
    KeptWindow window{{}, about.x, about.y, {f.centre, f.theta, f.ground}, {}, f.index};
    if (whole) {
      source.read(f.index, region, wide);
      window.picture = cut(wide, region, about);
      ground.add(wide, region.x, region.y, f.ground, {f.centre.x, f.centre.y, disc.rim().outer()});
    } else {
      source.read(f.index, about, window.picture);
    }
    window.spline = QuinticSpline(window.picture);
    kept.push_back(std::move(window));
  }
  ground.leave_out_what_stands_out(options.noise_variance);
  ground.finish(options.noise_variance);
  // Ground at rest that does not show the same in all frames: something may have crossed it.
  const bool restless = !options.motion_known && ground.unrest() > kRestless * options.noise_variance;
  if (restless) {
    UsualGround usual(region);
    const std::size_t apart = std::max<std::size_t>(1, windows / kUsualFrames);
    for (std::size_t k = 0; k < windows; k += apart) {
      const FirstPassFrame& f = frames[chosen[k]];
      source.read(f.index, region, wide);
      usual.add(wide, {f.centre.x, f.centre.y, disc.rim().outer()});
    }
    ground.hold_to(usual.median(), kHeldSd * std::sqrt(options.noise_variance));
    for (std::size_t k = 0; k < windows; k += ground_stride) {
      const FirstPassFrame& f = frames[chosen[k]];
      source.read(f.index, region, wide);
      ground.add(wide, region.x, region.y, f.ground, {f.centre.x, f.centre.y, disc.rim().outer()});
    }
    ground.leave_out_what_stands_out(options.noise_variance);
    ground.finish(options.noise_variance);
    out.crossed_share = 1 - ground.held_share();
  }
  if (restless &&
      (ground.unrest() > kRestless * options.noise_variance || ground.held_share() < kLeastHeld)) {
    out.why_not = "the ground changes from frame to frame and there is no marker to tell how it moves";
    return out;
  }
  out.windows = static_cast<int>(windows);
  out.ground_texture = ground.texture();

  // A part of the windows first, spread over the recording: most sweeps need no more.
  const std::size_t few = std::min(kEarly, windows);
  std::stable_partition(kept.begin(), kept.end(), [&, n = std::size_t{0}](const KeptWindow&) mutable {
    const std::size_t k = n++;
    return k * few / windows != (k + 1) * few / windows;
  });
  LayeredRegistration registration(disc, ground);
  std::optional<LayeredLearning> learning;
  const auto learn = [&](double noise_variance, double least = 0) {
    learning.emplace(disc, ground, registration, options.disc.radius, NoiseLaw{noise_variance, 0}, least);
    const std::span<KeptWindow> all(kept);
    return learning->run(all.first(few), all);
  };
  // A coder that drops the noise leaves errors that the noise between frames does not tell of; light that
  // stands in the picture leaves what only very noisy layers explain.
  const auto learnt_at_last = [&] {
    bool learnt = learn(options.noise_variance);
    for (double times = 1; !learnt && times <= kMostExcess; times *= 4) {
      const double noise = options.noise_variance + times * options.excess * options.excess;
      learnt = learn(noise, times > 1 ? noise : 0);
    }
    return learnt;
  };
  if (!learnt_at_last()) {
    out.why_not = "the layers do not explain most of the kept frames";
    return out;
  }
  out.bent_share = bent_share(kept, disc, learning->noise());
  LayeredLighting lighting(region, options.top_level);
  const std::vector<Point> unlit = centres(kept);
  if (out.bent_share > kBentShare)
    for (int round = 0; round < kLightRounds; ++round) {
      if (!lighting.learn(kept, disc, ground, learning->noise())) break;
      registration.set_standing_light(&lighting.light());
      if (!learnt_at_last()) {
        out.why_not = "light stands in the picture, and the layers do not explain most of the kept frames";
        return out;
      }
      ++out.light_rounds;
      out.light_unsettled = moved(lighting.learnt_from(), centres(kept));
      if (out.light_unsettled < kLightSettled * learning->sigma()) break;
    }
  out.light_moved = moved(unlit, centres(kept));
  const Point offset = learning->offset();
  out.noise = learning->noise();
  out.disc_radius = learning->disc_radius();
  out.disc_radius_sd = learning->disc_radius_sd();
  out.rim_excess = learning->rim_chi_squared() - 1;

  out.slow_error = learning->slow_error();
  // Each pixel's pictures took one of the windows' numbers, which the residuals that tell the noise lack.
  const double taken = static_cast<double>(windows) / static_cast<double>(windows - 1);
  const double widened =
      taken * std::max(1.0, learning->rim_chi_squared()) * std::max(1.0, out.slow_error.widening);
  registration.set_usual(std::max(1.0, learning->rim_chi_squared()));
  std::int64_t done = 0;
  for (const FirstPassFrame& f : frames) {
    const Rect window = window_about(f.centre, registration.reach() + 1, source.bounds());
    source.read(f.index, window, frame);
    if (lighting.found()) lighting.light().take_out(frame, window.x, window.y, true);
    auto fix = registration.refine(frame, window.x, window.y, {f.centre, f.theta, f.ground},
                                   learning->light().at(f.centre));
    if (fix) {
      fix->covariance *= widened;
      if (lighting.found())
        fix->covariance += lighting.covariance(fix->state.centre) +
                           std::pow(out.light_unsettled, 2) * Eigen::Matrix2d::Identity();
      fix->state.centre.x += offset.x;
      fix->state.centre.y += offset.y;
    }
    out.fixes.push_back(std::move(fix));
    if (options.progress) options.progress(++done);
  }
  return out;
}

}  // namespace tribotrack::vision
