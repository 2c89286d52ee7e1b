#include "vision/layers/pass.h"

#include <algorithm>
#include <cmath>

#include "vision/discs/disc_detection.h"
#include "vision/io/window.h"
#include "vision/layers/learning.h"
#include "vision/layers/pictures.h"
#include "vision/layers/windows.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kFewest = 12;    ///< frames to learn from
constexpr int kContext = 6;            ///< px kept beyond the part's grid
constexpr int kTaper = 4;              ///< px of the grid in which ground is taken to be uncovered
constexpr std::size_t kRun = 128;      ///< frames over which a constant residual is an offset
constexpr double kTurnVisible = 0.05;  ///< px rms at the rim: less rotation does not show
constexpr double kRestless = 2;        ///< ground variance in time over the noise's: something crosses it

class LayeredPass {
 public:
  LayeredPass(FrameSource& source, const std::vector<FirstPassFrame>& frames, const LayeredOptions& options,
              StageClock& clock)
      : source_(source),
        frames_(frames),
        options_(options),
        clock_(clock),
        learning_frames_(source, frames, options, layered_reach(options.disc.radius, options.blur),
                         layered_half(options.disc.radius, options.blur) - kTaper),
        ground_(learning_frames_.region()),
        registration_(ground_) {}

  LayeredResult run() {
    keep_windows();
    learn();
    if (learnt_.explained < kFewest) {
      out_.why_not = "the pictures learnt explain hardly any frame";
      return std::move(out_);
    }
    find_rim();
    measure();
    show();
    return std::move(out_);
  }

 private:
  bool turns() const;
  void keep_windows();
  void learn();
  void find_rim();
  void measure();
  void end_run(std::vector<ClusterPulls>& run);
  void show() const;

  FrameSource& source_;
  const std::vector<FirstPassFrame>& frames_;
  const LayeredOptions& options_;
  StageClock& clock_;
  LayeredResult out_;
  LearningFrames learning_frames_;
  GroundPicture ground_;
  std::vector<KeptWindow> kept_;
  LayeredRegistration registration_;
  LearntPart learnt_;
  std::size_t ended_ = 0;  ///< fixes whose covariance is known
  double slow_ = 0, slow_frames_ = 0, slow_weight_ = 0;
  Point offset_;  ///< of the rim's centre from the middle of the part's grid
};

/// Whether the part turns visibly: the angles of the first pass vary more, over the recording, than they
/// scatter from frame to frame.
bool LayeredPass::turns() const {
  if (!options_.turning) return false;
  double mean = 0, total = 0, white = 0;
  const auto n = static_cast<double>(frames_.size());
  for (const FirstPassFrame& f : frames_) mean += f.theta / n;
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    total += std::pow(frames_[k].theta - mean, 2) / n;
    if (k > 0) white += 0.5 * std::pow(frames_[k].theta - frames_[k - 1].theta, 2) / (n - 1);
  }
  return total - white > std::pow(kTurnVisible / options_.disc.radius, 2);
}

void LayeredPass::keep_windows() {
  const auto running = clock_.enter(Stage::layers_learning);
  kept_ = learning_frames_.read(ground_);
  if (ground_.unrest() > kRestless * options_.noise_variance) {
    learning_frames_.read_uncrossed(ground_);
    out_.crossed_share = 1 - ground_.held_share();
  }
  out_.windows = static_cast<int>(kept_.size());
  out_.ground_texture = ground_.texture();
}

void LayeredPass::learn() {
  const auto running = clock_.enter(Stage::layers_learning);
  learnt_ = learn_part(kept_, ground_, registration_,
                       {options_.disc.radius, options_.blur, options_.noise_variance, turns()});
  out_.rounds = learnt_.rounds;
}

/// Positions are those of the rim's centre, and the radius is that of the averaged picture.
void LayeredPass::find_rim() {
  const double half = learnt_.part.half;
  const auto rim = fit_disc(learnt_.part.level, {half, half, options_.disc.radius}, 2);
  if (!rim) return;
  offset_ = {rim->circle.x - half, rim->circle.y - half};
  out_.disc_radius = rim->circle.radius;
  out_.disc_radius_sd = rim->radius_sd;
}

/// Every frame, over the pictures as they are now.
void LayeredPass::measure() {
  const auto running = clock_.enter(Stage::layers_measuring);
  Picture frame;
  std::int64_t done = 0;
  std::vector<ClusterPulls> run;
  for (const FirstPassFrame& f : frames_) {
    const Rect window = window_about(f.centre, registration_.reach() + 1, source_.bounds());
    source_.read(f.index, window, frame);
    auto fix = registration_.refine(frame, window.x, window.y, {f.centre, f.theta, f.ground, 1, 0, 0, 1},
                                    learnt_.light.at(f.centre));
    if (fix) {
      run.push_back(registration_.cluster_pulls());
      fix->state.centre.x += offset_.x;
      fix->state.centre.y += offset_.y;
    }
    out_.fixes.push_back(std::move(fix));
    if (run.size() == kRun) end_run(run);
    if (options_.progress) options_.progress(++done);
  }
  end_run(run);
  if (slow_weight_ > 0) {
    out_.slow_sd = std::sqrt(slow_ / slow_weight_);
    out_.slow_frames = slow_ > 0 ? slow_frames_ / slow_ : 0;
  }
}

/// The covariances of the frames since the last run ended, by what their residuals do from frame to frame.
void LayeredPass::end_run(std::vector<ClusterPulls>& run) {
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
  const RunScatter scatter = run_scatter(run, registration_.share_taken());
  run.clear();
  for (LayeredFix* fix : fixes) {
    if (scatter.covariance.trace() > 0) {
      // In the shape of the run, in the size of this frame's own information and residuals.
      fix->covariance = scatter.covariance * (fix->covariance.trace() / (variance / n)) *
                        std::max(1.0, fix->chi_squared / (chi_squared / n));
    } else {
      fix->covariance *= std::max(1.0, fix->chi_squared);
    }
  }
  slow_ += n * scatter.slow;
  slow_frames_ += n * scatter.slow * scatter.slow_frames;
  slow_weight_ += n;
}

/// To the debug sink: the layers, and the frames chosen for it.
void LayeredPass::show() const {
  if (!options_.debug) return;
  const auto running = clock_.enter(Stage::debug_pictures);
  const LearntLayers layers{learnt_.part, ground_, registration_.chosen()};
  show_layers(layers, *options_.debug);
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    const auto shown = std::ranges::find(options_.shown, frames_[k].index, &ShownFrame::index);
    if (shown == options_.shown.end() || !out_.fixes[k]) continue;
    LayeredState state = out_.fixes[k]->state;
    state.centre.x -= offset_.x;
    state.centre.y -= offset_.y;
    show_layered_frame(layers, state, *shown, source_, *options_.debug);
  }
}

}  // namespace

bool is_learning_frame(std::int64_t place, std::int64_t total) {
  if (total <= kLearningFrames) return true;
  const std::int64_t last = total - 1, parts = kLearningFrames - 1;
  const std::int64_t next = (place * parts + last - 1) / last;  // the first that does not lie before it
  return next * last / parts == place;
}

int layered_half(double radius, double blur) {
  // The rim's blur, and a shadow: of a part a quarter of its radius high, a lamp at 45 degrees throws one of
  // a quarter of the radius.
  return static_cast<int>(std::ceil(radius * 1.25 + 4 * blur)) + kTaper;
}

double layered_reach(double radius, double blur) {
  return layered_half(radius, blur) + kContext;
}

LayeredResult layered_pass(FrameSource& source, const std::vector<FirstPassFrame>& frames,
                           const LayeredOptions& options, StageClock& clock) {
  if (frames.size() >= kFewest) return LayeredPass(source, frames, options, clock).run();
  LayeredResult out;
  out.why_not = "too few frames to learn the layers from";
  return out;
}

}  // namespace tribotrack::vision
