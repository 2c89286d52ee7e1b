#include "vision/layers/learning.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "vision/kernels/median.h"
#include "vision/layers/first_pass.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kEarly = 64;  ///< windows of most rounds
constexpr int kLastRounds = 10;     ///< over all of them
constexpr int kMostRounds = 8;
constexpr int kFirstFine = 2;      ///< rounds with all pixels, however strange
constexpr int kLook = 2;           ///< round over all windows in which a slope of the light is looked for
constexpr double kInsideRim = 3;   ///< blurs of the rim inside which it does not show
constexpr double kClearOfRim = 4;  ///< blurs of the rim within which a standing light is not learnt
constexpr double kSettled = 0.03;  ///< of the standard deviation: windows that move less have settled
constexpr std::size_t kFewestSlopes = 20;
constexpr double kWeakSlope = 0.5;  ///< sd of the light over the part's radius before anything is known of it

/// The part as a window shows it inside its rim, without a shadow: a start.
PartPictures as_shown(const KeptWindow& window, int half, double radius, double blur, double ground) {
  const int size = 2 * half + 1;
  PartPictures part{half, Picture(size, size), blurred_rim(half, radius, blur), Picture(size, size, 1e20F)};
  const double inside = std::max(0.0, radius - kInsideRim * blur);
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      const double rho = std::hypot(i - half, j - half), pull = rho > inside ? inside / rho : 1;
      const double shown = window.spline.value(window.state.centre.x + pull * (i - half) - window.x,
                                               window.state.centre.y + pull * (j - half) - window.y);
      const double share = part.share.at(i, j);
      part.level.at(i, j) = static_cast<float>((1 - share) * shown + share * ground);
    }
  return part;
}

bool turned_round(const std::vector<KeptWindow>& windows) {
  const auto angle = [](const KeptWindow& w) { return w.state.theta; };
  const auto [low, high] = std::ranges::minmax_element(windows, {}, angle);
  return high->state.theta - low->state.theta > 2 * std::numbers::pi;
}

/// Px about the centre within which the part shows its face alone.
double face_of(const LearningOptions& options) {
  return std::max(0.5 * options.radius, options.radius - kClearOfRim * options.blur);
}

class Learning {
 public:
  Learning(std::vector<KeptWindow>& windows, GroundPicture& ground, LayeredRegistration& registration,
           const LearningOptions& options)
      : windows_(windows),
        ground_(ground),
        registration_(registration),
        options_(options),
        explained_(windows.size(), true) {
    const int half = layered_half(options.radius, options.blur);
    out_.part = as_shown(windows[windows.size() / 2], half, options.radius, options.blur, ground.mean());
    ground.see_beside(windows, out_.part, options.hidden, options.noise_variance);
    if (options.turning)
      out_.texture =
          std::make_unique<TurningTexture>(half, options.radius, options.blur, turned_round(windows));
    prior_share_ = out_.part.share;
    if (options.standing_light)
      out_.standing = std::make_unique<StandingLight>(ground.region(), prior_share_);
  }

  LearntPart run() {
    // A part of the windows finds the pictures, all of them then make them quiet.
    active_ = std::span(windows_).first(options_.standing_light ? windows_.size() : spread_first());
    const bool all = active_.size() == windows_.size();
    rounds(kMostRounds, false);
    if (!all) {
      active_ = windows_;
      measure_windows(false);
    }
    // Pictures far from the truth would show a slope of the light where there is none.
    rounds(kLastRounds, !options_.even_light);
    StandingLight look(ground_.region(), prior_share_);
    look.look(windows_, out_.part, face_of(options_));
    out_.standing_evidence = look.evidence();
    return std::move(out_);
  }

 private:
  std::size_t spread_first();
  void rounds(int most, bool look_for_light);
  void learn_pictures();
  double measure_windows(bool look_for_light);
  void learn_light();

  std::vector<KeptWindow>& windows_;
  std::span<KeptWindow> active_;  ///< those at work
  GroundPicture& ground_;
  LayeredRegistration& registration_;
  const LearningOptions& options_;
  Picture prior_share_;
  std::vector<bool> explained_;
  std::vector<LayeredFix> fixes_;
  LearntPart out_;
};

/// Brings some windows, spread over all, to the front. How many.
std::size_t Learning::spread_first() {
  const std::size_t windows = windows_.size(), few = std::min(kEarly, windows);
  std::vector<KeptWindow> first, rest;
  for (std::size_t k = 0; k < windows; ++k) {
    const bool taken = k * few / windows != (k + 1) * few / windows;
    (taken ? first : rest).push_back(std::move(windows_[k]));
  }
  std::ranges::move(rest, std::ranges::move(first, windows_.begin()).out);
  return few;
}

void Learning::rounds(int most, bool look_for_light) {
  for (int round = 1; round <= most; ++round) {
    ++out_.rounds;
    learn_pictures();
    const bool look = look_for_light && (round == kLook || (round == kLook + 2 && out_.light.known()));
    const double moved = measure_windows(look);
    if (out_.rounds >= kFirstFine)
      ground_.see_beside(active_, out_.part, options_.hidden, options_.noise_variance);
    if (look) learn_light();
    if (out_.standing && out_.rounds > kFirstFine && round % 2 == 0)
      out_.standing->learn(windows_, out_.part, face_of(options_));
    if (round > kLook + 2 && moved < kSettled * out_.sigma) break;
  }
}

void Learning::learn_pictures() {
  PartRegression regression(out_.part, ground_);
  for (std::size_t k = 0; k < active_.size(); ++k) {
    if (!explained_[k]) continue;
    Picture turned;
    if (out_.texture) turned = out_.texture->at(active_[k].state.theta);
    regression.add(active_[k], out_.rounds > kFirstFine, out_.texture ? &turned : nullptr);
  }
  out_.part = regression.solve(options_.noise_variance, prior_share_, options_.standing_light);
  if (out_.texture) out_.texture->learn(active_, explained_, out_.part, ground_);
  registration_.set_part(out_.part, static_cast<double>(active_.size()), out_.texture.get());
}

/// Px rms by which the windows moved, without the mean.
double Learning::measure_windows(bool look_for_light) {
  fixes_.clear();
  std::vector<double> chi_squared, sigma;
  double square = 0;
  Point sum;
  for (std::size_t k = 0; k < active_.size(); ++k) {
    KeptWindow& w = active_[k];
    const LightPrior light =
        look_for_light ? LightPrior{0, 0, kWeakSlope / options_.radius} : out_.light.at(w.state.centre);
    const auto fix = registration_.refine(w.picture, w.x, w.y, w.state, light);
    explained_[k] = fix.has_value();
    if (!fix) continue;
    const double x = fix->state.centre.x - w.state.centre.x, y = fix->state.centre.y - w.state.centre.y;
    square += x * x + y * y;
    sum.x += x;
    sum.y += y;
    w.state = fix->state;
    chi_squared.push_back(fix->chi_squared);
    sigma.push_back(std::sqrt(0.5 * fix->covariance.trace()));
    fixes_.push_back(*fix);
  }
  const auto n = static_cast<double>(fixes_.size());
  out_.explained = fixes_.size();
  if (fixes_.empty()) return 0;
  out_.chi_squared = median(chi_squared);
  out_.sigma = median(sigma) * std::sqrt(out_.chi_squared);
  return std::sqrt(std::max(0.0, (square - (sum.x * sum.x + sum.y * sum.y) / n) / (2 * n)));
}

/// How uneven the light is, by the windows: a frame alone hardly sees it.
void Learning::learn_light() {
  if (fixes_.size() < kFewestSlopes) return;
  std::vector<MeasuredSlope> slopes;
  for (const LayeredFix& f : fixes_)
    slopes.push_back({f.state.centre, f.state.slope_x, f.state.slope_y, f.slope_variance * out_.chi_squared});
  out_.light = IlluminationSlope(slopes);
}

}  // namespace

LearntPart learn_part(std::vector<KeptWindow>& windows, GroundPicture& ground,
                      LayeredRegistration& registration, const LearningOptions& options) {
  return Learning(windows, ground, registration, options).run();
}

}  // namespace tribotrack::vision
