#include "vision/layers/pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vision/discs/disc_detection.h"
#include "vision/layers/evidence.h"
#include "vision/layers/learning.h"
#include "vision/layers/measuring.h"
#include "vision/layers/pictures.h"
#include "vision/layers/windows.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kFewest = 12;   ///< frames to learn from
constexpr int kContext = 6;           ///< px kept beyond the part's grid
constexpr int kTaper = 4;             ///< px of the grid in which ground is taken to be uncovered
constexpr double kFewestKnown = 0.2;  ///< share of the ground that must be seen beside the part's grid
constexpr double kClear = 6;          ///< blurs beside the rim
constexpr double kRestless = 2;       ///< ground variance in time over the noise's: something crosses it
/// Of the pictures' noise: a template quieter than this is chosen. One that holds ground at its edge is held
/// back by it, which makes it quieter by up to a third, and wrong.
constexpr double kQuieter = 0.5;

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
    } else {
      measure();
      if (out_.why_not.empty()) take();
    }
    return std::move(out_);
  }

 private:
  void keep_windows();
  void learn();
  void measure();
  void take();
  void show();

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
  MeasuredFrames measured_;
  double hidden_ = 0;  ///< px about the part within which there is no ground
};

void LayeredPass::keep_windows() {
  const auto running = clock_.enter(Stage::layers_learning);
  kept_ = learning_frames_.read(ground_);
  // A picture that holds little more than the part shows its ground beside it only, in what shadow there is.
  hidden_ = layered_half(options_.disc.radius, options_.blur) - kTaper;
  if (ground_.known_share() < kFewestKnown) {
    hidden_ = options_.disc.radius + kClear * options_.blur;
    learning_frames_.read_ground(ground_, hidden_);
  }
  if (ground_.unrest() > kRestless * options_.noise_variance) {
    learning_frames_.read_uncrossed(ground_);
    out_.crossed_share = 1 - ground_.held_share();
    out_.ground_known = ground_.unrest() <= kRestless * options_.noise_variance;
  }
  out_.windows = static_cast<int>(kept_.size());
  out_.ground_texture = ground_.texture();
}

void LayeredPass::learn() {
  const auto running = clock_.enter(Stage::layers_learning);
  learnt_ = learn_part(kept_, ground_, registration_,
                       {.radius = options_.disc.radius,
                        .blur = options_.blur,
                        .noise_variance = options_.noise_variance,
                        .hidden = hidden_,
                        .threads = options_.threads});
}

/// And whether that is to be used: not where the first pass is much quieter than pictures can be.
void LayeredPass::measure() {
  const auto running = clock_.enter(Stage::layers_measuring);
  measured_ = measure_frames(source_, frames_, registration_, learnt_, options_.threads, options_.progress);
  std::vector<TimedPoint> first, track;
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    first.push_back({frames_[k].index, frames_[k].centre});
    if (const auto& fix = measured_.fixes[k]) track.push_back({frames_[k].index, fix->state.centre});
  }
  const double by_template = frame_noise(first), by_pictures = frame_noise(track);
  out_.noise = fmt::format("single template {:.4f} px, pictures {:.4f} px and {:.4f} px slow", by_template,
                           by_pictures, measured_.slow_sd);
  if (track.empty())
    out_.why_not = "the pictures learnt explain hardly any frame";
  else if (by_template < kQuieter * by_pictures)
    out_.why_not = "noise from frame to frame: " + out_.noise;
}

/// Positions are those of the rim's centre, and the radius is that of the averaged picture.
void LayeredPass::take() {
  out_.rounds = learnt_.rounds;
  out_.slow_sd = measured_.slow_sd;
  out_.slow_frames = measured_.slow_frames;
  out_.audited = std::move(measured_.audited);
  show();
  out_.fixes = std::move(measured_.fixes);
  const double half = learnt_.part.half;
  const auto rim = fit_disc(learnt_.part.level, {half, half, options_.disc.radius}, 2);
  if (!rim) return;
  for (auto& fix : out_.fixes) {
    if (!fix) continue;
    fix->state.centre.x += rim->circle.x - half;
    fix->state.centre.y += rim->circle.y - half;
  }
  out_.disc_radius = rim->circle.radius;
  out_.disc_radius_sd = rim->radius_sd;
}

/// To the debug sink: the layers, and the frames chosen for it.
void LayeredPass::show() {
  if (!options_.debug) return;
  const auto running = clock_.enter(Stage::debug_pictures);
  registration_.set_part(learnt_.part, static_cast<double>(kept_.size()));
  const LearntLayers layers{learnt_.part, ground_, registration_.chosen()};
  show_layers(layers, *options_.debug);
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    const auto shown = std::ranges::find(options_.shown, frames_[k].index, &ShownFrame::index);
    const auto& fix = measured_.fixes[k];
    if (shown != options_.shown.end() && fix)
      show_layered_frame(layers, fix->state, *shown, source_, *options_.debug);
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
