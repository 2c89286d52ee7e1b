
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "vision/io/levels.h"
#include "vision/kernels/median.h"
#include "vision/kernels/parallel.h"
#include "vision/layers/layers.h"
#include "vision/layers/model/model.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kEarly = 64;  ///< windows of most rounds
constexpr int kMostRounds = 8;      ///< over these
constexpr int kLastRounds = 8;      ///< over all
constexpr int kFewestRounds = 2;
constexpr int kFirstFine = 2;  ///< rounds with all pixels, however strange
constexpr int kFirstLook = 2;  ///< round over all windows in which a slope of the light is looked for
constexpr int kLooks = 2;
constexpr double kInsideRim = 3;  ///< blurs of the rim inside which it does not show
constexpr double kRest = 0.14;    ///< of the standard deviation: what is left makes it a percent larger
constexpr double kSlowest = 0.9;  ///< by which a round's moves are taken to shrink
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

class Learning {
 public:
  Learning(std::vector<KeptWindow>& windows, GroundPicture& ground, LayeredRegistration& registration,
           const FirstPassResult& first, double hidden, int threads)
      : windows_(windows),
        ground_(ground),
        registration_(registration),
        first_(first),
        hidden_(hidden),
        threads_(threads),
        fixes_(windows.size()),
        explained_(windows.size(), true) {
    const int half = layered_half(first.disc.radius, first.blur);
    out_.part = as_shown(windows[windows.size() / 2], half, first.disc.radius, first.blur, ground.mean());
    prior_share_ = blurred_rim(half, first.disc.radius, first.blur);
  }

  LearntPart run() {
    // A part of the windows finds the pictures, all of them then make them quiet.
    look_at(kEarly);
    see_ground();
    rounds(kMostRounds, false);
    look_at(windows_.size());
    if (windows_.size() > kEarly) measure_windows();
    // Pictures far from the truth would show a slope of the light where there is none.
    rounds(kLastRounds, true);
    return std::move(out_);
  }

 private:
  void look_at(std::size_t most);
  void rounds(int most, bool look_for_light);
  void learn_pictures();
  void see_ground();
  void refine_windows(bool look_for_light);
  double measure_windows();
  void learn_light();

  std::vector<KeptWindow>& windows_;
  std::vector<std::size_t> active_;  ///< places of the windows at work
  GroundPicture& ground_;
  LayeredRegistration& registration_;
  const FirstPassResult& first_;
  double hidden_;
  int threads_;
  Picture prior_share_;
  std::vector<std::optional<LayeredFix>> fixes_;  ///< of the last measurement, by the window's place
  std::vector<bool> explained_;
  LearntPart out_;
};

/// So many windows, spread over all.
void Learning::look_at(std::size_t most) {
  active_.clear();
  const std::size_t n = windows_.size();
  most = std::min(most, n);
  for (std::size_t k = 0; k < n; ++k)
    if (k * most / n != (k + 1) * most / n) active_.push_back(k);
}

/// Until what further rounds would move is lost in the noise.
void Learning::rounds(int most, bool look_for_light) {
  double before = 0;
  int looks = look_for_light ? kLooks : 0;
  for (int round = 1; round <= most; ++round) {
    ++out_.rounds;
    learn_pictures();
    const bool look = looks > 0 && round >= kFirstLook;
    if (look) {
      learn_light();
      looks = out_.light.known() ? looks - 1 : 0;
    }
    const double moved = measure_windows();
    if (out_.rounds >= kFirstFine) see_ground();
    // Rounds shrink in a geometric series: so much is left of it.
    const double shrinks = std::min(kSlowest, before > 0 ? moved / before : kSlowest);
    const bool settled = moved * shrinks / (1 - shrinks) < kRest * out_.sigma;
    before = look ? 0 : moved;
    if (settled && !look && looks == 0 && round > kFewestRounds) break;
  }
}

void Learning::learn_pictures() {
  std::vector<const KeptWindow*> windows;
  for (const std::size_t k : active_)
    if (explained_[k]) windows.push_back(&windows_[k]);
  out_.part = vision::learn_pictures(out_.part, ground_, windows, out_.rounds > kFirstFine,
                                     first_.noise_variance, prior_share_, threads_);
  registration_.set_part(out_.part, static_cast<double>(active_.size()));
}

void Learning::see_ground() {
  std::vector<const KeptWindow*> windows;
  for (const std::size_t k : active_) windows.push_back(&windows_[k]);
  ground_.see_beside(windows, out_.part, hidden_, first_.noise_variance, threads_);
}

/// Where each window shows the part by the pictures as they stand; windows keep their states.
void Learning::refine_windows(bool look_for_light) {
  std::vector<LayeredRegistration> registrations(static_cast<std::size_t>(std::max(1, threads_)),
                                                 registration_);
  parallel_for(active_.size(), threads_, [&](std::size_t i, std::size_t worker) {
    const KeptWindow& w = windows_[active_[i]];
    const LightPrior light =
        look_for_light ? LightPrior{0, 0, kWeakSlope / first_.disc.radius} : out_.light.at(w.state.centre);
    fixes_[active_[i]] = registrations[worker].refine(w.picture, w.x, w.y, w.state, light);
  });
}

/// Px rms by which the windows moved, without the mean.
double Learning::measure_windows() {
  refine_windows(false);
  std::vector<double> chi_squared, sigma;
  double square = 0;
  Point sum;
  for (const std::size_t k : active_) {
    KeptWindow& w = windows_[k];
    const auto& fix = fixes_[k];
    explained_[k] = fix.has_value();
    if (!fix) continue;
    const double x = fix->state.centre.x - w.state.centre.x, y = fix->state.centre.y - w.state.centre.y;
    square += x * x + y * y;
    sum.x += x;
    sum.y += y;
    w.state = fix->state;
    chi_squared.push_back(fix->chi_squared);
    sigma.push_back(std::sqrt(0.5 * fix->covariance.trace()));
  }
  const auto n = static_cast<double>(sigma.size());
  out_.explained = sigma.size();
  if (sigma.empty()) return 0;
  out_.chi_squared = median(chi_squared);
  out_.sigma = median(sigma) * std::sqrt(out_.chi_squared);
  return std::sqrt(std::max(0.0, (square - (sum.x * sum.x + sum.y * sum.y) / n) / (2 * n)));
}

/// How uneven the light is, by the windows: a frame alone hardly sees it.
void Learning::learn_light() {
  refine_windows(true);
  std::vector<MeasuredSlope> slopes;
  for (const std::size_t k : active_)
    if (const auto& f = fixes_[k])
      slopes.push_back(
          {f->state.centre, f->state.slope_x, f->state.slope_y, f->slope_variance * out_.chi_squared});
  if (slopes.size() >= kFewestSlopes) out_.light = IlluminationSlope(slopes);
}

}  // namespace

LearntPart learn_part(std::vector<KeptWindow>& windows, GroundPicture& ground,
                      LayeredRegistration& registration, const FirstPassResult& first, double hidden,
                      int threads) {
  return Learning(windows, ground, registration, first, hidden, threads).run();
}

namespace {

constexpr double kKeptBytes = 140e6;   ///< of memory for the windows and the pictures learnt
constexpr double kGroundPixels = 4e6;  ///< of all frames the platform's picture is averaged from
constexpr double kGroundFrames = 40;   ///< and no fewer frames than these
constexpr double kFewestGround = 12;   ///< frames spread over the recording
constexpr double kStep = 0.5;          ///< px: the least step of a part that moves
constexpr double kGroundBytes = 40;    ///< per px: the platform's pictures, those of a moment included
constexpr double kFewestWindows = 16;

/// Places in `frames` of those that are spread over the whole recording, and read whole by the first pass
/// where it is decoded; all where too few of them show the part.
std::vector<std::size_t> spread_in_time(const SeenFrames& frames, const FirstPassResult& first) {
  std::vector<std::size_t> spread;
  for (std::size_t k = 0; k < frames.size(); ++k)
    if (is_learning_frame(frames[k].index - first.first_index, first.total)) spread.push_back(k);
  if (static_cast<double>(spread.size()) >= kFewestGround) return spread;
  spread.resize(frames.size());
  std::iota(spread.begin(), spread.end(), std::size_t{0});
  return spread;
}

/// How far the part has gone by each frame, px: standing still counts nothing, noise neither.
std::vector<double> way(const SeenFrames& frames) {
  std::vector<double> out;
  Point last = frames.front().centre;
  double gone = 0;
  for (const FirstPassFrame& f : frames) {
    const double step = std::hypot(f.centre.x - last.x, f.centre.y - last.y);
    if (step > kStep) {
      gone += step;
      last = f.centre;
    }
    out.push_back(gone);
  }
  return out;
}

/// Places in `frames` of those to learn from, `most` at most: even in time and way alike, for a part that
/// moves looks different from one at rest (light, coder, blur).
std::vector<std::size_t> choose_windows(const SeenFrames& frames, std::size_t most) {
  const std::vector<double> gone = way(frames);
  const auto progress = [&](std::size_t k) {
    const double in_time = static_cast<double>(k) / static_cast<double>(frames.size());
    return gone.back() > 0 ? 0.5 * (in_time + gone[k] / gone.back()) : in_time;
  };
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < frames.size(); ++k)
    if (frames.size() <= most ||
        progress(k) * static_cast<double>(most) >= static_cast<double>(chosen.size()))
      chosen.push_back(k);
  return chosen;
}

/// Places of the platform, in its frame, that are seen about the part's path.
Rect swath(const SeenFrames& frames, double reach, const Rect& bounds) {
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9, away = 0;
  for (const FirstPassFrame& f : frames) {
    x0 = std::min(x0, f.centre.x);
    x1 = std::max(x1, f.centre.x);
    y0 = std::min(y0, f.centre.y);
    y1 = std::max(y1, f.centre.y);
    away = std::max(away, std::hypot(f.ground.x, f.ground.y));
  }
  // Platform that moves brings places into the picture that lie outside it at first.
  const int beyond = static_cast<int>(std::ceil(away));
  const Rect places = {bounds.x - beyond, bounds.y - beyond, bounds.width + 2 * beyond,
                       bounds.height + 2 * beyond};
  const double margin = reach + 2 * away + 4;
  return touched_pixels(x0 - margin, y0 - margin, x1 + margin, y1 + margin, places);
}

}  // namespace

LearningFrames::LearningFrames(FrameSource& source, const SeenFrames& frames, const FirstPassResult& first,
                               double reach)
    : source_(source),
      frames_(frames),
      first_(first),
      reach_(reach),
      region_(swath(frames, reach, source.bounds())),
      read_(common(region_, source.bounds())) {
  const double window_bytes =
      4 * (std::pow(2 * reach + 2, 2) + std::pow(2 * (reach + QuinticSpline::kPad) + 2, 2));
  const double area = static_cast<double>(region_.width) * region_.height;
  // The platform's pictures live beside the windows.
  const double room = kKeptBytes - kGroundBytes * area;
  const double most = std::min<double>(kLearningFrames, room / window_bytes);
  chosen_ = choose_windows(frames, static_cast<std::size_t>(std::max(kFewestWindows, most)));
  const double averaged = std::max(kGroundFrames, kGroundPixels / area);
  const std::vector<std::size_t> spread = spread_in_time(frames, first);
  const auto stride =
      static_cast<std::size_t>(std::max(1.0, std::ceil(static_cast<double>(spread.size()) / averaged)));
  for (std::size_t k = 0; k < spread.size(); k += stride) ground_frames_.push_back(spread[k]);
}

std::vector<KeptWindow> LearningFrames::read_windows() const {
  std::vector<KeptWindow> kept;
  for (const std::size_t k : chosen_) {
    const FirstPassFrame& f = frames_[k];
    const Rect about = window_about(f.centre, reach_, source_.bounds());
    KeptWindow window{{}, about.x, about.y, {f.centre, f.ground, 1, 0, 0, 1}, {}};
    source_.read(f.index, about, window.picture);
    window.spline = QuinticSpline(window.picture);
    kept.push_back(std::move(window));
  }
  return kept;
}

void LearningFrames::read_ground(GroundPicture& ground, double hidden) const {
  ground.forget();
  Picture wide;
  for (const std::size_t k : ground_frames_) {
    source_.read(frames_[k].index, read_, wide);
    const Point& part = frames_[k].centre;
    ground.add(wide, read_.x, read_.y, frames_[k].ground, {part.x, part.y, hidden});
  }
  ground.finish(first_.noise_variance);
}

}  // namespace tribotrack::vision
