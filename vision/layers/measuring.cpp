#include "vision/layers/measuring.h"

#include <cmath>

#include "vision/audit/runs.h"
#include "vision/io/window.h"

namespace tribotrack::vision {
namespace {

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

}  // namespace

MeasuredFrames measure_frames(FrameSource& source, const std::vector<FirstPassFrame>& frames,
                              LayeredRegistration& registration, const LearntPart& learnt,
                              const std::function<void(std::int64_t done)>& progress) {
  MeasuredFrames out;
  Runs runs(out, registration);
  const std::vector<AuditRun> wanted = audit_runs(0, static_cast<std::int64_t>(frames.size()));
  Picture picture;
  std::int64_t done = 0;
  for (const FirstPassFrame& f : frames) {
    const Rect window = window_about(f.centre, registration.reach() + 1, source.bounds());
    source.read(f.index, window, picture);
    out.fixes.push_back(measure(f, window, picture, registration, learnt));
    if (out.fixes.back()) {
      if (in_audit(wanted, done))
        if (const auto halves = registration.halves())
          out.audited.push_back({.index = done, .error = *halves});
      runs.add(registration.cluster_pulls());
    }
    ++done;
    if (progress) progress(done);
  }
  runs.finish();
  for (AuditFrame& frame : out.audited) {
    frame.covariance = out.fixes[static_cast<std::size_t>(frame.index)]->covariance;
    frame.index = frames[static_cast<std::size_t>(frame.index)].index;
  }
  return out;
}

}  // namespace tribotrack::vision
