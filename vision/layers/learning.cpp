#include "vision/layers/learning.h"

#include <algorithm>
#include <cmath>

#include "vision/kernels/median.h"
#include "vision/layers/first_pass.h"

namespace tribotrack::vision {
namespace {

constexpr int kMostRounds = 12;
constexpr int kFirstFine = 2;      ///< round from which the light's slope is looked for and strange pixels left out
constexpr double kSettled = 0.05;  ///< of the standard deviation: windows that move less have settled
constexpr double kWeakGround = 0.3;  ///< sd of the ground's gain before anything is known of it
constexpr double kWeakSlope = 0.5;   ///< likewise of the light over the part's radius

/// The part as the first window shows it: a start.
PartPictures as_shown(const KeptWindow& window, int half, double radius, double blur) {
  const int size = 2 * half + 1;
  PartPictures part{half, Picture(size, size), blurred_rim(half, radius, blur), Picture(size, size, 1e20F)};
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i)
      part.level.at(i, j) = static_cast<float>(window.spline.value(window.state.centre.x - half + i - window.x,
                                                                   window.state.centre.y - half + j - window.y));
  return part;
}

/// What a quantity scatters beyond its own uncertainty; 0 where that is not significant.
double true_sd(const std::vector<double>& squares, double variance) {
  if (squares.empty()) return 0;
  double sum = 0;
  for (const double s : squares) sum += s;
  const auto n = static_cast<double>(squares.size());
  return sum / n > variance * (1 + 2 * std::sqrt(2 / n)) ? std::sqrt(sum / n - variance) : 0;
}

class Learning {
 public:
  Learning(std::vector<KeptWindow>& windows, const GroundPicture& ground, LayeredRegistration& registration,
           double radius, double blur, double noise_variance)
      : windows_(windows),
        ground_(ground),
        registration_(registration),
        radius_(radius),
        noise_variance_(noise_variance),
        explained_(windows.size(), true) {
    const int half = layered_half(radius, blur);
    out_.part = as_shown(windows[windows.size() / 2], half, radius, blur);
    prior_share_ = out_.part.share;
    out_.light.ground_sd = kWeakGround;
  }

  LearntPart run() {
    for (out_.rounds = 1; out_.rounds <= kMostRounds; ++out_.rounds) {
      learn_pictures();
      if (out_.rounds == kFirstFine + 1) out_.light.slope_sd = kWeakSlope / radius_;
      const double moved = measure_windows();
      if (out_.rounds == kFirstFine + 1) learn_light();
      if (out_.rounds > kFirstFine + 1 && moved < kSettled * out_.sigma) break;
    }
    return std::move(out_);
  }

 private:
  void learn_pictures();
  double measure_windows();
  void learn_light();

  std::vector<KeptWindow>& windows_;
  const GroundPicture& ground_;
  LayeredRegistration& registration_;
  double radius_, noise_variance_;
  Picture prior_share_;
  std::vector<bool> explained_;
  std::vector<LayeredFix> fixes_;
  LearntPart out_;
};

void Learning::learn_pictures() {
  PartRegression regression(out_.part, ground_);
  for (std::size_t k = 0; k < windows_.size(); ++k)
    if (explained_[k]) regression.add(windows_[k], out_.rounds > kFirstFine);
  out_.part = regression.solve(noise_variance_, prior_share_);
  registration_.set_part(out_.part, static_cast<double>(windows_.size()));
}

/// Px rms by which the windows moved, without the mean.
double Learning::measure_windows() {
  fixes_.clear();
  std::vector<double> chi_squared, sigma;
  double square = 0;
  Point sum;
  for (std::size_t k = 0; k < windows_.size(); ++k) {
    KeptWindow& w = windows_[k];
    const auto fix = registration_.refine(w.picture, w.x, w.y, w.state, out_.light);
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
  std::vector<double> slopes;
  double slope_variance = 0;
  for (const LayeredFix& f : fixes_) {
    slopes.push_back(f.state.slope_x * f.state.slope_x);
    slopes.push_back(f.state.slope_y * f.state.slope_y);
    slope_variance += f.slope_variance * out_.chi_squared / static_cast<double>(fixes_.size());
  }
  out_.light.slope_sd = true_sd(slopes, slope_variance);
  if (out_.light.slope_sd > 0) return;
  for (KeptWindow& w : windows_) w.state.slope_x = w.state.slope_y = 0;
}

}  // namespace

LearntPart learn_part(std::vector<KeptWindow>& windows, const GroundPicture& ground,
                      LayeredRegistration& registration, double radius, double blur, double noise_variance) {
  return Learning(windows, ground, registration, radius, blur, noise_variance).run();
}

}  // namespace tribotrack::vision
