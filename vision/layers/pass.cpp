#include "vision/layers/pass.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "vision/io/window.h"
#include "vision/layers/learning/illumination_test.h"
#include "vision/layers/learning/learning.h"
#include "vision/layers/learning/lighting.h"
#include "vision/layers/learning/windows.h"
#include "vision/layers/pictures.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kEarly = 32;   ///< windows of most sweeps
constexpr int kContext = 6;          ///< px kept beyond the disc's pictures
constexpr std::size_t kFewest = 12;  ///< frames to learn from
constexpr double kLeastHeld = 0.7;   ///< of uncovered ground that shows the same in all frames: else it moves
constexpr double kRestless = 2;      ///< ground variance in time over the noise's: it moves
constexpr double kBentShare = 0.1;   ///< of the windows: less is chance, or something that crosses
constexpr int kLightRounds = 16;
constexpr double kLightSettled = 0.05;  ///< of the standard deviation: converged when windows move less
constexpr double kMostExcess = 64;      ///< times the first pass's, in variance
constexpr double kTurnVisible = 0.15;   ///< px at the rim: less rotation over the recording is ignored

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

std::vector<Point> centres(std::span<const KeptWindow> windows) {
  std::vector<Point> out;
  for (const KeptWindow& w : windows) out.push_back(w.state.centre);
  return out;
}

/// Px rms per coordinate, without the common mean.
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

class LayeredPass {
 public:
  LayeredPass(FrameSource& source, const std::vector<FirstPassFrame>& frames, const LayeredOptions& options,
              StageClock& clock)
      : source_(source),
        frames_(frames),
        options_(options),
        clock_(clock),
        disc_(options.disc.radius, options.blur, turns(frames, options)),
        learning_frames_(source, frames, options, layered_reach(options.disc.radius, options.blur),
                         disc_.rim().outer(), disc_.turning()),
        ground_(learning_frames_.region()),
        registration_(disc_, ground_),
        lighting_(learning_frames_.region(), options.top_level) {}

  LayeredResult run() {
    if (keep_windows() && learn_layers() && learn_light()) {
      report_what_was_learnt();
      measure();
      show();
    }
    return std::move(out_);
  }

 private:
  bool keep_windows();
  bool learn_layers();
  bool learn_light();
  void report_what_was_learnt();
  void measure();
  void show() const;

  bool learn(double noise_variance, double least_noise);
  bool fails(const char* why_not) {
    out_.why_not = why_not;
    return false;
  }

  FrameSource& source_;
  const std::vector<FirstPassFrame>& frames_;
  const LayeredOptions& options_;
  StageClock& clock_;
  LayeredResult out_;
  LayeredDisc disc_;
  LearningFrames learning_frames_;
  GroundPicture ground_;
  std::vector<KeptWindow> kept_;
  LayeredRegistration registration_;
  std::optional<LayeredLearning> learning_;
  LayeredLighting lighting_;
};

bool LayeredPass::keep_windows() {
  const auto running = clock_.enter(Stage::layers_learning);
  kept_ = learning_frames_.read(ground_);
  const auto restless = [&] { return ground_.unrest() > kRestless * options_.noise_variance; };
  // Ground at rest that differs between frames: something may have crossed it.
  if (!options_.motion_known && restless()) {
    learning_frames_.read_uncrossed(ground_);
    out_.crossed_share = 1 - ground_.held_share();
    if (restless() || ground_.held_share() < kLeastHeld)
      return fails("the ground changes from frame to frame and there is no marker to measure its motion");
  }
  out_.windows = static_cast<int>(kept_.size());
  out_.ground_texture = ground_.texture();
  // A part of the windows first, spread over the recording: most sweeps need no more.
  const std::size_t windows = kept_.size(), few = std::min(kEarly, windows);
  std::stable_partition(kept_.begin(), kept_.end(), [&, n = std::size_t{0}](const KeptWindow&) mutable {
    const std::size_t k = n++;
    return k * few / windows != (k + 1) * few / windows;
  });
  return true;
}

bool LayeredPass::learn(double noise_variance, double least_noise) {
  learning_.emplace(disc_, ground_, registration_, options_.disc.radius, NoiseLaw{noise_variance, 0},
                    least_noise);
  const std::span<KeptWindow> all(kept_);
  return learning_->run(all.first(std::min(kEarly, all.size())), all);
}

/// Coding errors exceed the noise seen between frames, and static illumination not yet taken out is only
/// explained by very noisy layers: where the measured noise does not do, larger ones are tried.
bool LayeredPass::learn_layers() {
  const auto running = clock_.enter(Stage::layers_learning);
  bool learnt = learn(options_.noise_variance, 0);
  for (double times = 1; !learnt && times <= kMostExcess; times *= 4) {
    const double noise = options_.noise_variance + times * options_.excess * options_.excess;
    learnt = learn(noise, times > 1 ? noise : 0);
  }
  return learnt || fails("the layers do not explain most of the kept frames");
}

/// Layers and static illumination in turn.
bool LayeredPass::learn_light() {
  const auto running = clock_.enter(Stage::layers_illumination);
  if (!options_.static_illumination) return true;
  out_.curved_light_share = curved_light_share(kept_, disc_, learning_->noise());
  if (!(out_.curved_light_share > kBentShare)) return true;
  const std::vector<Point> unlit = centres(kept_);
  for (int round = 0; round < kLightRounds; ++round) {
    if (!lighting_.learn(kept_, disc_, ground_, learning_->noise())) break;
    registration_.set_illumination(&lighting_.light());
    if (!learn_layers())
      return fails("with static illumination the layers do not explain most of the kept frames");
    ++out_.light_rounds;
    out_.light_unsettled = moved(lighting_.learnt_from(), centres(kept_));
    if (out_.light_unsettled < kLightSettled * learning_->sigma()) break;
  }
  out_.light_moved = moved(unlit, centres(kept_));
  return true;
}

void LayeredPass::report_what_was_learnt() {
  out_.noise = learning_->noise();
  out_.disc_radius = learning_->disc_radius();
  out_.disc_radius_sd = learning_->disc_radius_sd();
  out_.rim_excess = learning_->rim_chi_squared() - 1;
  out_.slow_error = learning_->slow_error();
}

/// Every frame, over the layers as they are now.
void LayeredPass::measure() {
  const auto running = clock_.enter(Stage::layers_measuring);
  const Point offset = learning_->offset();
  // Each pixel's pictures took one degree of freedom from the residuals that the noise was estimated from.
  const double taken = static_cast<double>(kept_.size()) / static_cast<double>(kept_.size() - 1);
  const double usual = std::max(1.0, learning_->rim_chi_squared());
  const double widened = taken * usual * std::max(1.0, out_.slow_error.widening);
  registration_.set_usual(usual);
  Picture frame;
  std::int64_t done = 0;
  for (const FirstPassFrame& f : frames_) {
    const Rect window = window_about(f.centre, registration_.reach() + 1, source_.bounds());
    source_.read(f.index, window, frame);
    if (lighting_.found()) lighting_.light().take_out(frame, window.x, window.y, true);
    auto fix = registration_.refine(frame, window.x, window.y, {f.centre, f.theta, f.ground},
                                    learning_->light().at(f.centre));
    if (fix) {
      fix->covariance *= widened;
      if (lighting_.found())
        fix->covariance += lighting_.covariance(fix->state.centre) +
                           std::pow(out_.light_unsettled, 2) * Eigen::Matrix2d::Identity();
      fix->state.centre.x += offset.x;
      fix->state.centre.y += offset.y;
    }
    out_.fixes.push_back(std::move(fix));
    if (options_.progress) options_.progress(++done);
  }
}

/// To the debug sink: the layers, and the frames chosen for it.
void LayeredPass::show() const {
  if (!options_.debug) return;
  const auto running = clock_.enter(Stage::debug_pictures);
  const LearntLayers layers{disc_, ground_, registration_.chosen(),
                            lighting_.found() ? &lighting_.light() : nullptr};
  show_layers(layers, *options_.debug);
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    const auto shown = std::ranges::find(options_.shown, frames_[k].index, &ShownFrame::index);
    if (shown == options_.shown.end() || !out_.fixes[k]) continue;
    LayeredState state = out_.fixes[k]->state;
    state.centre.x -= learning_->offset().x;
    state.centre.y -= learning_->offset().y;
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

double layered_reach(double radius, double blur) {
  return LayeredDisc::half_of(radius, blur) + kContext;
}

LayeredResult layered_pass(FrameSource& source, const std::vector<FirstPassFrame>& frames,
                           const LayeredOptions& options, StageClock& clock) {
  if (frames.size() >= kFewest) return LayeredPass(source, frames, options, clock).run();
  LayeredResult out;
  out.why_not = "too few frames to learn the layers from";
  return out;
}

}  // namespace tribotrack::vision
