#include "vision/layers/layers.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <span>
#include <utility>

#include "vision/audit/halves.h"
#include "vision/io/levels.h"
#include "vision/kernels/parallel.h"

namespace tribotrack::vision {
namespace {

using Pulls = std::vector<ClusterPulls>;

/// Sum over the clusters of the mean over frame k of x_k . x_(k + lag), half of it: of a coordinate.
double correlation(const Pulls& frames, std::size_t lag) {
  double sum = 0;
  for (std::size_t k = 0; k + lag < frames.size(); ++k)
    for (std::size_t c = 0; c < frames[k].size(); ++c)
      sum += 0.5 * static_cast<double>(frames[k][c].dot(frames[k + lag][c]));
  return sum / static_cast<double>(frames.size() - lag);
}

Pulls about_their_mean(Pulls frames) {
  const std::size_t clusters = frames.front().size();
  for (std::size_t c = 0; c < clusters; ++c) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const ClusterPulls& f : frames) sum += f[c].cast<double>();
    const Eigen::Vector2f mean = (sum / static_cast<double>(frames.size())).cast<float>();
    for (ClusterPulls& f : frames) f[c] -= mean;
  }
  return frames;
}

}  // namespace

RunScatter run_scatter(const Pulls& frames, const Eigen::Array2d& taken) {
  RunScatter out;
  const auto n = static_cast<double>(frames.size());
  if (frames.size() < 4) return out;
  const Pulls about = about_their_mean(frames);
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const ClusterPulls& f : about)
    for (const Eigen::Vector2f& pull : f) {
      const Eigen::Vector2d x = pull.cast<double>();
      sum += x * x.transpose();
    }
  const Eigen::Vector2d left = (1 - taken).rsqrt();
  out.covariance = left.asDiagonal() * sum * left.asDiagonal() / (n - 1);
  // Half the square of a difference; the mean has taken nothing of it.
  const double all = correlation(about, 0), next = correlation(about, 1);
  out.white = std::min((all - next) / (1 - taken.mean()), 0.5 * out.covariance.trace());
  out.slow = 0.5 * out.covariance.trace() - out.white;
  if (!(next > 0)) return out;
  double integral = 0.5;
  for (std::size_t lag = 1; lag < frames.size() / 2; ++lag) {
    const double share = correlation(about, lag) / next;
    if (share <= 0) break;
    integral += share;
  }
  out.slow_frames = integral;
  return out;
}

namespace {

constexpr std::size_t kAtOnce = 64;  ///< frames shared among the threads
constexpr std::size_t kRun = 128;    ///< frames over which a constant residual is an offset

/// What is slow in the runs so far, weighted by their frames.
struct SlowSums {
  double variance = 0, frames = 0, weight = 0;
};

/// Gives the frames of a run their covariance.
void end_run(std::span<std::optional<LayeredFix>> run, const RunScatter& scatter, SlowSums& slow) {
  double n = 0, chi_squared = 0, variance = 0;
  for (const auto& fix : run) {
    if (!fix) continue;
    ++n;
    chi_squared += fix->chi_squared;
    variance += fix->covariance.trace();
  }
  for (auto& fix : run) {
    if (!fix) continue;
    if (scatter.covariance.trace() > 0)
      // In the shape of the run, in the size of this frame's own information and residuals.
      fix->covariance = scatter.covariance * (fix->covariance.trace() / (variance / n)) *
                        (fix->chi_squared / (chi_squared / n));
    else
      fix->covariance *= fix->chi_squared;
  }
  slow.variance += n * scatter.slow;
  slow.frames += n * scatter.slow * scatter.slow_frames;
  slow.weight += n;
}

/// What one frame gives.
struct Sight {
  std::optional<LayeredFix> fix;
  std::optional<HalvesError> halves;
  ClusterPulls pulls;
};

}  // namespace

MeasuredFrames measure_frames(FrameSource& source, const SeenFrames& frames,
                              const LayeredRegistration& registration, const LearntPart& learnt, int threads,
                              const std::function<void(std::int64_t done)>& progress) {
  MeasuredFrames out;
  SlowSums slow;
  Pulls pulls;            // of the run at hand
  std::size_t begun = 0;  // its first frame
  const auto end = [&] {
    end_run(std::span(out.fixes).subspan(begun), run_scatter(pulls, registration.share_taken()), slow);
    begun = out.fixes.size();
    pulls.clear();
  };
  std::vector<LayeredRegistration> registrations(static_cast<std::size_t>(std::max(1, threads)),
                                                 registration);
  std::mutex reading;
  std::vector<Sight> sights;
  for (std::size_t first = 0; first < frames.size(); first += kAtOnce) {
    sights.assign(std::min(kAtOnce, frames.size() - first), {});
    parallel_for(sights.size(), threads, [&](std::size_t i, std::size_t worker) {
      const FirstPassFrame& f = frames[first + i];
      LayeredRegistration& own = registrations[worker];
      const Rect window = window_about(f.centre, own.reach() + 1, source.bounds());
      thread_local Picture picture;
      {
        const std::lock_guard lock(reading);
        source.read(f.index, window, picture);
      }
      sights[i].fix = own.refine(picture, window.x, window.y, {f.centre, f.ground, 1, 0, 0, 1},
                                 learnt.light.at(f.centre));
      if (!sights[i].fix) return;
      if (in_audit(static_cast<std::int64_t>(first + i), std::ssize(frames))) sights[i].halves = own.halves();
      sights[i].pulls = own.cluster_pulls();
    });
    for (std::size_t i = 0; i < sights.size(); ++i) {
      out.fixes.push_back(sights[i].fix);
      if (sights[i].halves)
        out.audited.push_back({.index = static_cast<std::int64_t>(first + i), .error = *sights[i].halves});
      if (sights[i].fix) pulls.push_back(std::move(sights[i].pulls));
      if (pulls.size() == kRun) end();
    }
    if (progress) progress(static_cast<std::int64_t>(first + sights.size()));
  }
  end();
  if (slow.variance > 0) {
    out.slow_sd = std::sqrt(slow.variance / slow.weight);
    out.slow_frames = slow.frames / slow.variance;
  }
  for (AuditFrame& frame : out.audited) {
    frame.covariance = out.fixes[static_cast<std::size_t>(frame.index)]->covariance;
    frame.index = frames[static_cast<std::size_t>(frame.index)].index;
  }
  return out;
}

namespace {

constexpr double kBeyond = 2;  ///< px shown about the part's grid

Picture ground_levels(const GroundPicture& ground) {
  const Rect& region = ground.region();
  Picture level(region.width, region.height);
  ground.spline().sample_window(0, 0, region.width, region.height, level.levels().data(), nullptr, nullptr);
  for (float& l : level.levels()) l += static_cast<float>(ground.mean());
  return level;
}

/// The model of model.h over a window of the camera.
Picture predicted(const PartPictures& part, const GroundPicture& ground, const LayeredState& state,
                  const Rect& window) {
  const QuinticSpline level(part.level), share(part.share);
  const Rect& region = ground.region();
  const double half = part.half;
  Picture out(window.width, window.height);
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      const double u = window.x + x - state.centre.x, v = window.y + y - state.centre.y;
      const SplineSample below = ground.spline().sample(window.x + x - state.ground.x - region.x,
                                                        window.y + y - state.ground.y - region.y);
      const bool on_grid = std::abs(u) <= half && std::abs(v) <= half;
      const double own = on_grid ? level.value(half + u, half + v) : ground.mean();
      const SplineSample shows = on_grid ? share.sample(half + u, half + v) : SplineSample{1, 0, 0};
      const double blended = part.blend * (shows.slope_x * below.slope_x + shows.slope_y * below.slope_y);
      const double shine = state.gain * (1 + state.slope_x * u + state.slope_y * v), mean = ground.mean();
      out.at(x, y) = static_cast<float>(shine * (own - shows.value * mean) +
                                        state.ground_gain * (shows.value * (below.value + mean) + blended));
    }
  return out;
}

}  // namespace

void show_layers(const PartPictures& part, const GroundPicture& ground, const MeasuredFrames& measured,
                 const SeenFrames& frames, const ShownFrames& shown, FrameSource& source, DebugSink& sink) {
  const double half = part.half;
  const Point corner{static_cast<double>(ground.region().x), static_cast<double>(ground.region().y)};
  sink.show({.name = "layers_part",
             .title = "the part learnt, on ground of mean level",
             .levels = part.level,
             .first = {-half, -half},
             .place = "from the part's centre"});
  sink.show({.name = "layers_share",
             .title = "share of the ground that shows",
             .levels = part.share,
             .unit = "share",
             .first = {-half, -half},
             .place = "from the part's centre"});
  sink.show({.name = "layers_ground",
             .title = "the background learnt (the platform)",
             .levels = ground_levels(ground),
             .first = corner,
             .place = "of the platform"});
  for (const auto& frame : shown) {
    const auto at = std::ranges::find(frames, frame.first, &FirstPassFrame::index);
    if (at == frames.end()) continue;
    const auto& fix = measured.fixes[static_cast<std::size_t>(at - frames.begin())];
    if (!fix) continue;
    const Rect window = window_about(fix->state.centre, part.half + kBeyond, source.bounds());
    show_prediction(window_of(source, frame, window), predicted(part, ground, fix->state, window), "layers",
                    "part over background at the measured place", "layers: camera minus prediction", sink);
  }
}

}  // namespace tribotrack::vision
