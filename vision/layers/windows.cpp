#include "vision/layers/windows.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "vision/io/levels.h"
#include "vision/layers/model/ground.h"
#include "vision/layers/stage.h"

namespace tribotrack::vision {
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
std::vector<std::size_t> spread_in_time(const std::vector<FirstPassFrame>& frames,
                                        const FirstPassResult& first) {
  std::vector<std::size_t> spread;
  for (std::size_t k = 0; k < frames.size(); ++k)
    if (is_learning_frame(frames[k].index - first.first_index, first.total)) spread.push_back(k);
  if (static_cast<double>(spread.size()) >= kFewestGround) return spread;
  spread.resize(frames.size());
  std::iota(spread.begin(), spread.end(), std::size_t{0});
  return spread;
}

/// How far the part has gone by each frame, px: standing still counts nothing, noise neither.
std::vector<double> way(const std::vector<FirstPassFrame>& frames) {
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
std::vector<std::size_t> choose_windows(const std::vector<FirstPassFrame>& frames, std::size_t most) {
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

}  // namespace

Rect swath(const std::vector<FirstPassFrame>& frames, double reach, const Rect& bounds) {
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

LearningFrames::LearningFrames(FrameSource& source, const std::vector<FirstPassFrame>& frames,
                               const FirstPassResult& first, double reach, double hidden)
    : source_(source),
      frames_(frames),
      first_(first),
      reach_(reach),
      hidden_(hidden),
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

std::vector<KeptWindow> LearningFrames::read(GroundPicture& ground) {
  read_ground(ground);
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

void LearningFrames::read_ground(GroundPicture& ground, double hidden) {
  hidden_ = hidden;
  ground.forget();
  read_ground(ground);
}

void LearningFrames::read_ground(GroundPicture& ground) {
  Picture wide;
  for (const std::size_t k : ground_frames_) {
    source_.read(frames_[k].index, read_, wide);
    ground.add(wide, read_.x, read_.y, frames_[k].ground, part_in(frames_[k]));
  }
  ground.finish(first_.noise_variance);
}

}  // namespace tribotrack::vision
