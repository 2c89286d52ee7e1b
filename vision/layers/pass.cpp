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

constexpr std::size_t kFewest = 12;    ///< frames to learn from
constexpr int kContext = 6;            ///< px kept beyond the part's grid
constexpr int kTaper = 4;              ///< px of the grid in which ground is taken to be uncovered
constexpr double kTurnVisible = 0.05;  ///< px rms at the rim: less rotation does not show
/// Times what changes at a pixel from frame to frame: less may be the part's own picture, not known well.
constexpr double kStands = 2;
constexpr double kFewestKnown = 0.2;  ///< share of the ground that must be seen beside the part's grid
constexpr double kClear = 6;          ///< blurs beside the rim
constexpr double kRestless = 2;       ///< ground variance in time over the noise's: something crosses it
constexpr double kFewer = 0.9;        ///< of the frames another candidate explains: too few to be chosen
constexpr double kClearlyQuieter = 0.9;
/// Of the pictures' noise: a template quieter than this is chosen. One that holds ground at its edge is held
/// back by it, which makes it quieter by up to a third, and wrong.
constexpr double kQuieter = 0.5;

/// Pictures learnt, and what they make of the recording.
struct Candidate {
  std::string name;
  LearntPart learnt;
  MeasuredFrames measured;
  bool even_light = false;
  std::int64_t explained = 0;  ///< frames
  double noise = 0;            ///< from frame to frame, px
  double error() const { return std::hypot(noise, measured.slow_sd); }
};

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
    std::vector<Candidate> candidates;
    candidates.push_back(tried("pictures that do not turn", {}));
    const LearningStart early = std::move(candidates.front().learnt.early);
    if (candidates.front().learnt.light.known())
      candidates.push_back(tried("in even light", {.even_light = true, .start = &early}));
    if (options_.static_light && candidates.front().learnt.standing_evidence > kStands)
      candidates.push_back(tried("with light that stands in the picture", {.standing_light = true}));
    if (turns()) candidates.push_back(tried("with a texture that turns", {.turning = true}));
    Candidate* best = choose(candidates);
    if (best) take(*best);
    return std::move(out_);
  }

 private:
  void keep_windows();
  bool turns() const;
  Candidate tried(const char* name, LearningOptions learning);
  Candidate* choose(std::vector<Candidate>& candidates);
  void take(Candidate& candidate);
  void show(const Candidate& candidate);

  FrameSource& source_;
  const std::vector<FirstPassFrame>& frames_;
  const LayeredOptions& options_;
  StageClock& clock_;
  LayeredResult out_;
  LearningFrames learning_frames_;
  GroundPicture ground_;
  std::vector<KeptWindow> kept_;
  std::vector<LayeredState> first_states_;  ///< of these
  LayeredRegistration registration_;
  bool measured_once_ = false;  ///< progress is told of once
  double hidden_ = 0;           ///< px about the part within which there is no ground
};

void LayeredPass::keep_windows() {
  const auto running = clock_.enter(Stage::layers_learning);
  kept_ = learning_frames_.read(ground_);
  for (const KeptWindow& w : kept_) first_states_.push_back(w.state);
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

Candidate LayeredPass::tried(const char* name, LearningOptions learning) {
  Candidate out{.name = name, .learnt = {}, .measured = {}, .even_light = learning.even_light};
  {
    const auto running = clock_.enter(Stage::layers_learning);
    learning.threads = options_.threads;
    learning.radius = options_.disc.radius;
    learning.blur = options_.blur;
    learning.noise_variance = options_.noise_variance;
    learning.hidden = hidden_;
    if (learning.standing_light) {  // it is taken out of the windows
      std::vector<KeptWindow> windows = kept_;
      out.learnt = learn_part(windows, ground_, registration_, learning);
    } else {
      out.learnt = learn_part(kept_, ground_, registration_, learning);
      for (std::size_t k = 0; k < kept_.size(); ++k) kept_[k].state = first_states_[k];
    }
  }
  if (out.learnt.explained < kFewest) return out;
  const auto running = clock_.enter(Stage::layers_measuring);
  out.measured = measure_frames(source_, frames_, registration_, out.learnt, options_.threads,
                                measured_once_ ? nullptr : options_.progress);
  measured_once_ = true;
  std::vector<TimedPoint> track;
  for (std::size_t k = 0; k < frames_.size(); ++k)
    if (const auto& fix = out.measured.fixes[k]) track.push_back({frames_[k].index, fix->state.centre});
  out.explained = static_cast<std::int64_t>(track.size());
  out.noise = frame_noise(track);
  return out;
}

/// By evidence: the track that is quietest, its slow error included; null for that of the first pass. Even
/// light must be clearly quieter: what uneven light does to a track is slow.
Candidate* LayeredPass::choose(std::vector<Candidate>& candidates) {
  std::vector<TimedPoint> first;
  for (const FirstPassFrame& f : frames_) first.push_back({f.index, f.centre});
  const double template_noise = frame_noise(first);
  out_.candidates = fmt::format("single template {:.4f} px", template_noise);
  Candidate* best = nullptr;
  for (Candidate& c : candidates) {
    if (c.explained == 0) continue;
    out_.candidates += fmt::format(", {} {:.4f} px and {:.4f} px slow", c.name, c.noise, c.measured.slow_sd);
    const bool fewer =
        best && static_cast<double>(c.explained) < kFewer * static_cast<double>(best->explained);
    const bool quieter =
        best && (c.even_light ? c.noise < kClearlyQuieter * best->noise : c.error() < best->error());
    if (!best || (!fewer && quieter)) best = &c;
  }
  if (!best) {
    out_.why_not = "the pictures learnt explain hardly any frame";
  } else if (template_noise < kQuieter * best->noise) {
    out_.why_not = "noise from frame to frame: " + out_.candidates;
    best = nullptr;
  }
  return best;
}

/// Positions are those of the rim's centre, and the radius is that of the averaged picture.
void LayeredPass::take(Candidate& candidate) {
  out_.rounds = candidate.learnt.rounds;
  out_.slow_sd = candidate.measured.slow_sd;
  out_.slow_frames = candidate.measured.slow_frames;
  out_.audited = std::move(candidate.measured.audited);
  show(candidate);
  out_.fixes = std::move(candidate.measured.fixes);
  const double half = candidate.learnt.part.half;
  const auto rim = fit_disc(candidate.learnt.part.level, {half, half, options_.disc.radius}, 2);
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
void LayeredPass::show(const Candidate& candidate) {
  if (!options_.debug) return;
  const auto running = clock_.enter(Stage::debug_pictures);
  registration_.set_part(candidate.learnt.part, static_cast<double>(kept_.size()),
                         candidate.learnt.texture.get());
  const LearntLayers layers{candidate.learnt.part, candidate.learnt.texture.get(), ground_,
                            registration_.chosen()};
  show_layers(layers, *options_.debug);
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    const auto shown = std::ranges::find(options_.shown, frames_[k].index, &ShownFrame::index);
    const auto& fix = candidate.measured.fixes[k];
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
