#include "vision/layers/measuring.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "vision/audit/halves.h"
#include "vision/io/levels.h"
#include "vision/kernels/parallel.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kAtOnce = 64;  ///< frames shared among the threads
constexpr int kPasses = 3;
constexpr double kClose = 0.02;    ///< px: a light known to a tenth of its slope per pixel then moves nothing
constexpr std::size_t kRun = 128;  ///< frames over which a constant residual is an offset

/// Gathers frames into runs, and gives each run's frames their covariance.
class Runs {
 public:
  Runs(MeasuredFrames& out, const LayeredRegistration& registration)
      : out_(out), registration_(registration) {}

  void add(ClusterPulls pulls) {
    pulls_.push_back(std::move(pulls));
    if (pulls_.size() == kRun) end_run();
  }

  void finish() {
    end_run();
    if (!(slow_ > 0)) return;
    out_.slow_sd = std::sqrt(slow_ / weight_);
    out_.slow_frames = slow_frames_ / slow_;
  }

 private:
  void end_run();

  MeasuredFrames& out_;
  const LayeredRegistration& registration_;
  std::vector<ClusterPulls> pulls_;
  std::size_t ended_ = 0;  ///< frames of the runs before
  double slow_ = 0, slow_frames_ = 0, weight_ = 0;
};

void Runs::end_run() {
  std::vector<LayeredFix*> fixes;
  double chi_squared = 0, variance = 0;
  for (std::size_t k = ended_; k < out_.fixes.size(); ++k)
    if (out_.fixes[k]) {
      fixes.push_back(&*out_.fixes[k]);
      chi_squared += fixes.back()->chi_squared;
      variance += fixes.back()->covariance.trace();
    }
  ended_ = out_.fixes.size();
  const auto n = static_cast<double>(fixes.size());
  const RunScatter scatter = run_scatter(pulls_, registration_.share_taken());
  pulls_.clear();
  for (LayeredFix* fix : fixes)
    if (scatter.covariance.trace() > 0) {
      // In the shape of the run, in the size of this frame's own information and residuals.
      fix->covariance = scatter.covariance * (fix->covariance.trace() / (variance / n)) *
                        (fix->chi_squared / (chi_squared / n));
    } else {
      fix->covariance *= fix->chi_squared;
    }
  slow_ += n * scatter.slow;
  slow_frames_ += n * scatter.slow * scatter.slow_frames;
  weight_ += n;
}

/// A standing light is taken out of the frame first, and again where the part lies elsewhere than thought.
std::optional<LayeredFix> measure(const FirstPassFrame& f, const Rect& window, const Picture& picture,
                                  LayeredRegistration& registration, const LearntPart& learnt) {
  const LayeredState start{f.centre, f.theta, f.ground, 1, 0, 0, 1};
  const LightPrior light = learnt.light.at(f.centre);
  if (!learnt.standing) return registration.refine(picture, window.x, window.y, start, light);
  std::optional<LayeredFix> fix;
  Point centre = f.centre;
  for (int pass = 0; pass < kPasses; ++pass) {
    Picture unlit = picture;
    learnt.standing->take_out(unlit, window.x, window.y, centre);
    fix = registration.refine(unlit, window.x, window.y, start, light);
    if (!fix) return fix;
    const double off = std::hypot(fix->state.centre.x - centre.x, fix->state.centre.y - centre.y);
    centre = fix->state.centre;
    if (off < kClose) break;
  }
  return fix;
}

/// What one frame gives.
struct Sight {
  std::optional<LayeredFix> fix;
  std::optional<HalvesError> halves;
  ClusterPulls pulls;
};

}  // namespace

MeasuredFrames measure_frames(FrameSource& source, const std::vector<FirstPassFrame>& frames,
                              const LayeredRegistration& registration, const LearntPart& learnt, int threads,
                              const std::function<void(std::int64_t done)>& progress) {
  MeasuredFrames out;
  Runs runs(out, registration);
  const std::vector<AuditRun> wanted = audit_runs(0, static_cast<std::int64_t>(frames.size()));
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
      sights[i].fix = measure(f, window, picture, own, learnt);
      if (!sights[i].fix) return;
      if (in_audit(wanted, static_cast<std::int64_t>(first + i))) sights[i].halves = own.halves();
      sights[i].pulls = own.cluster_pulls();
    });
    for (std::size_t i = 0; i < sights.size(); ++i) {
      out.fixes.push_back(sights[i].fix);
      if (sights[i].halves)
        out.audited.push_back({.index = static_cast<std::int64_t>(first + i), .error = *sights[i].halves});
      if (sights[i].fix) runs.add(std::move(sights[i].pulls));
    }
    if (progress) progress(static_cast<std::int64_t>(first + sights.size()));
  }
  runs.finish();
  for (AuditFrame& frame : out.audited) {
    frame.covariance = out.fixes[static_cast<std::size_t>(frame.index)]->covariance;
    frame.index = frames[static_cast<std::size_t>(frame.index)].index;
  }
  return out;
}

}  // namespace tribotrack::vision
