#include "vision/rotation/rotation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <span>

#include "vision/io/levels.h"
#include "vision/kernels/parallel.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kTrial = 16;       ///< frames after which it is given up where nothing is seen
constexpr std::size_t kAtOnce = kTrial;  ///< frames shared among the threads
constexpr double kFewest = 0.5;          ///< of the frames must show the rotation
constexpr double kLargestSd = 0.2;       ///< rad: known less well than that it is not seen

/// The weights of the inner rings, so many that both parts know the angle about equally well in this frame.
Eigen::ArrayXXf inner_half(const Harmonics& first, const Eigen::ArrayXXf& weights) {
  const Eigen::ArrayXf orders =
      Eigen::ArrayXf::LinSpaced(first.rows(), 0, static_cast<float>(first.rows() - 1));
  const Eigen::ArrayXf of_ring =
      ((weights * first.abs2()).colwise() * orders.square()).colwise().sum().transpose();
  Eigen::ArrayXXf inner = Eigen::ArrayXXf::Zero(weights.rows(), weights.cols());
  float sum = 0;
  for (Eigen::Index k = 0; k + 1 < weights.cols() && (k == 0 || sum < 0.5F * of_ring.sum()); ++k) {
    inner.col(k) = weights.col(k);
    sum += of_ring(k);
  }
  return inner;
}

/// What was seen in all frames.
struct Turns {
  std::vector<std::optional<Turn>> all;
  std::vector<std::optional<double>> apart;  ///< angle by the inner less that by the outer rings
  std::size_t seen = 0;
};

/// What the rings show in some of the frames.
std::vector<Harmonics> harmonics_of(FrameSource& source, std::span<const FirstPassFrame> frames,
                                    std::vector<RingHarmonics>& rings) {
  std::vector<Harmonics> out(frames.size());
  std::mutex reading;
  parallel_for(frames.size(), static_cast<int>(rings.size()), [&](std::size_t k, std::size_t worker) {
    const FirstPassFrame& f = frames[k];
    const Rect place = window_about(f.centre, rings[worker].reach(), source.bounds());
    Picture window;
    {
      const std::lock_guard lock(reading);
      source.read(f.index, place, window);
    }
    out[k] = rings[worker].of(window, {f.centre.x - place.x, f.centre.y - place.y});
  });
  return out;
}

Turns followed(FrameSource& source, std::span<const FirstPassFrame> frames, const RingHarmonics& rings,
               int threads) {
  Turns out;
  std::vector<RingHarmonics> own(static_cast<std::size_t>(std::max(1, threads)), rings);
  std::vector<Harmonics> some;
  std::optional<RotationFollower> all, inner, outer;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (k % kAtOnce == 0)
      some = harmonics_of(source, frames.subspan(k, std::min(kAtOnce, frames.size() - k)), own);
    const FirstPassFrame& f = frames[k];
    const Harmonics& seen = some[k % kAtOnce];
    if (!all) {
      const Eigen::ArrayXXf near_centre = inner_half(seen, rings.weights());
      all.emplace(seen, rings.weights(), f.index);
      inner.emplace(seen, near_centre, f.index);
      outer.emplace(seen, rings.weights() - near_centre, f.index);
      out.all.push_back(Turn{0, all->information(), 0});
      out.apart.emplace_back(0.0);
      continue;
    }
    out.all.push_back(all->step(seen, f.index));
    const auto a = inner->step(seen, f.index), b = outer->step(seen, f.index);
    out.apart.push_back(a && b ? std::optional(a->theta - b->theta) : std::nullopt);
    out.seen += out.all.back().has_value();
    if (out.all.size() == kTrial && static_cast<double>(out.seen) < kFewest * kTrial) break;
  }
  return out;
}

/// How the angles by both halves differ: a quarter of the difference's variance is that of the angle by both,
/// if they err independently.
struct Halves {
  double white = 0;  ///< variance of the angle, rad^2, from one frame to the next
  double drift = 0;  ///< variance that each radian turned adds, rad
};

Halves halves_of(const Turns& turns) {
  double turned = 0, of_turned = 0, square = 0, step = 0, count = 0, last = 0, before = 0;
  for (std::size_t k = 1; k < turns.all.size(); ++k) {
    if (!turns.all[k] || !turns.apart[k]) continue;
    turned += std::abs(turns.all[k]->theta - last);
    last = turns.all[k]->theta;
    of_turned += turned;
    square += *turns.apart[k] * *turns.apart[k];
    step += std::pow(*turns.apart[k] - before, 2);
    before = *turns.apart[k];
    ++count;
  }
  if (count == 0) return {};
  const double white = 0.5 * step;
  return {0.25 * white / count, of_turned > 0 ? std::max(0.0, 0.25 * (square - white) / of_turned) : 0};
}

/// Variance of an angle times its information: by the pulls of the harmonics or by the halves, whichever is
/// larger. Either misses errors: those that harmonics, or halves, have in common.
double white_ratio(const Turns& turns, double by_halves) {
  double scatter = 0, information = 0, of_unit = 0, count = 0;
  for (const auto& turn : turns.all)
    if (turn && turn->scatter > 0) {
      scatter += turn->scatter;
      information += turn->information;
      of_unit += 1 / turn->information;
      ++count;
    }
  if (count == 0) return 0;
  return std::max(scatter / information, by_halves * count / of_unit);
}

}  // namespace

std::vector<std::optional<Rotation>> follow_rotation(FrameSource& source, const SeenFrames& frames,
                                                     double radius, double blur, int threads) {
  const RingHarmonics rings(radius, blur);
  if (!rings.usable() || frames.size() < 2) return {};
  const Turns turns = followed(source, frames, rings, threads);
  if (turns.all.size() < frames.size() ||
      static_cast<double>(turns.seen) < kFewest * static_cast<double>(frames.size() - 1))
    return {};
  const Halves halves = halves_of(turns);
  const double ratio = white_ratio(turns, halves.white);
  std::vector<std::optional<Rotation>> out(frames.size());
  double turned = 0, last = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const auto& turn = turns.all[k];
    if (!turn || !(turn->information > 0)) continue;
    turned += std::abs(turn->theta - last);
    last = turn->theta;
    const double sigma = std::sqrt(ratio / turn->information + halves.drift * turned);
    if (sigma < kLargestSd) out[k] = Rotation{turn->theta, sigma};
  }
  return out;
}

namespace {

void take_template(const FirstPassResult& first, Track& track) {
  std::optional<double> origin;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const PartLook& look = first.looks[k];
    if (track.points[k].status != TrackStatus::ok || !(look.sigma_theta > 0)) continue;
    if (!origin) origin = look.theta;
    track.points[k].rotation = Rotation{look.theta - *origin, look.sigma_theta};
  }
  track.has_rotation = origin.has_value();
}

PlanStage by_rings(FrameSource& source, const FirstPassResult& first, Track& track, int threads) {
  PlanStage stage{.name = "rotation by rings", .reason = "its texture is not seen again in most frames"};
  const SeenFrames frames = seen_frames(track, first.first_index);
  const auto seen = follow_rotation(source, frames, first.disc.radius, first.blur, threads);
  double low = 0, high = 0;
  std::size_t count = 0;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (!seen[k]) continue;
    track.points[frames[k].place].rotation = seen[k];
    low = std::min(low, seen[k]->theta);
    high = std::max(high, seen[k]->theta);
    ++count;
  }
  track.has_rotation = stage.on = count > 0;
  if (stage.on)
    stage.reason = fmt::format(
        "{} frames compared ring by ring with a picture learnt on the way; the part turns through {:.3g} rad",
        count, high - low);
  return stage;
}

}  // namespace

void measure_rotation(FrameSource& source, const FirstPassResult& first, Track& track,
                      std::vector<PlanStage>& plan, int threads) {
  if (!first.texture_seen) return;
  if (first.disc.radius > 0)
    plan.push_back(by_rings(source, first, track, threads));
  else if (first.turning)
    take_template(first, track);
}

}  // namespace tribotrack::vision
