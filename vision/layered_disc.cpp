#include "vision/layered_disc.h"

#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr int kContext = 2;             ///< px of grid beyond the rim's reach
constexpr double kLeastCoverage = 0.3;  ///< of the disc, for its texture to be read there
constexpr int kBackfits = 3;

/// Whether a place of the camera lies in the window, where it may be interpolated.
bool inside(const KeptWindow& w, double x, double y) {
  return x >= w.x && y >= w.y && x <= w.x + w.picture.width() - 1 && y <= w.y + w.picture.height() - 1;
}

}  // namespace

LayeredDisc::LayeredDisc(double radius, double blur, bool turning)
    : radius_(radius), turning_(turning), rim_(radius, blur) {
  half_ = static_cast<int>(std::ceil(rim_.outer())) + kContext;
  const int size = 2 * half_ + 1;
  standing_ = Picture(size, size);
  texture_ = Picture(size, size);
  make_share();
  texture_spline_ = QuinticSpline(texture_);
}

void LayeredDisc::make_share() {
  const int size = 2 * half_ + 1;
  share_ = Picture(size, size);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      share_.at(x, y) = static_cast<float>(rim_.at(std::hypot(x - half_, y - half_)));
}

Picture LayeredDisc::at(double theta, Picture* slope) const {
  Picture out = standing_;
  if (slope) *slope = Picture(out.width(), out.height());
  if (!turning_) return out;
  // Counter-clockwise with y up is, in pixels with y down, (x, y) -> (c x + s y, -s x + c y).
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x) {
      const float cover = 1 - share_.at(x, y);
      if (cover <= 0) continue;
      const double ux = c * (x - half_) - s * (y - half_);
      const double uy = s * (x - half_) + c * (y - half_);
      const SplineSample t = texture_spline_.sample(half_ + ux, half_ + uy);
      out.at(x, y) += cover * static_cast<float>(t.value);
      if (slope) slope->at(x, y) = cover * static_cast<float>(-t.slope_x * uy + t.slope_y * ux);
    }
  return out;
}

Picture LayeredDisc::on_plain(double level) const {
  Picture out = standing_;
  for (std::size_t i = 0; i < out.levels().size(); ++i)
    out.levels()[i] += static_cast<float>(level) * share_.levels()[i];
  return out;
}

/// Per pixel of the disc, over the frames: y what the disc shows in its own light, z the ground beneath in
/// the same light.
struct LayeredDisc::Sums {
  double n = 0, y = 0, z = 0, yz = 0, zz = 0;
};

void LayeredDisc::learn_standing(const std::vector<KeptWindow>& windows, const GroundPicture& ground,
                                 double noise_variance, bool with_rim) {
  const int size = 2 * half_ + 1;
  const auto pixels = static_cast<std::size_t>(size) * size;
  std::vector<Sums> sums(pixels);
  std::vector<float> level(pixels), below(pixels), known(pixels);
  for (const KeptWindow& w : windows) {
    const LayeredState& s = w.state;
    const double left = s.centre.x - half_;
    const double top = s.centre.y - half_;
    QuinticSpline(w.picture).sample_window(left - w.x, top - w.y, size, size, level.data(), nullptr, nullptr);
    ground.sample(left - s.ground.x, top - s.ground.y, size, size, below.data(), known.data());
    Picture turned;
    if (turning_) {
      turned = at(s.theta);
      for (std::size_t i = 0; i < pixels; ++i) turned.levels()[i] -= standing_.levels()[i];
    }
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const auto k = static_cast<std::size_t>(j) * size + i;
        if (!inside(w, left + i, top + j)) continue;
        if (share_.levels()[k] > 0 && known[k] == 0) continue;
        const double light = s.gain * (1 + s.slope_x * (i - half_) + s.slope_y * (j - half_));
        const double y = level[k] / light - (turning_ ? turned.levels()[k] : 0.0F);
        const double z = s.ground_gain * below[k] / light;
        Sums& sum = sums[k];
        sum.n += 1;
        sum.y += y;
        sum.z += z;
        sum.yz += y * z;
        sum.zz += z * z;
      }
  }
  if (with_rim) {
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const Sums& sum = sums[static_cast<std::size_t>(j) * size + i];
        if (sum.n < 3) continue;
        rim_.add(std::hypot(i - half_, j - half_), sum.yz - sum.y * sum.z / sum.n,
                 sum.zz - sum.z * sum.z / sum.n);
      }
    rim_.solve(noise_variance);
    make_share();
  }
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      const auto k = static_cast<std::size_t>(j) * size + i;
      const Sums& sum = sums[k];
      const bool beyond = std::hypot(i - half_, j - half_) >= rim_.outer();
      if (beyond) {
        standing_.levels()[k] = 0;
      } else if (sum.n > 0) {
        standing_.levels()[k] = static_cast<float>((sum.y - share_.levels()[k] * sum.z) / sum.n);
      }
    }
}

void LayeredDisc::learn_turning(const std::vector<KeptWindow>& windows, const GroundPicture& ground) {
  const int size = 2 * half_ + 1;
  const auto pixels = static_cast<std::size_t>(size) * size;
  std::vector<double> above(pixels, 0.0), weight(pixels, 0.0);
  std::vector<float> below(pixels), known(pixels);
  const QuinticSpline standing(standing_);
  for (const KeptWindow& w : windows) {
    const LayeredState& s = w.state;
    // What is left of the frame on the camera's own grid about the disc's whole pixel, then turned back.
    const QuinticSpline picture(w.picture);
    const double c = std::cos(s.theta);
    const double sine = std::sin(s.theta);
    ground.sample(s.centre.x - half_ - s.ground.x, s.centre.y - half_ - s.ground.y, size, size, below.data(),
                  known.data());
    Picture rest(size, size);
    std::vector<float> level(pixels);
    picture.sample_window(s.centre.x - half_ - w.x, s.centre.y - half_ - w.y, size, size, level.data(),
                          nullptr, nullptr);
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const auto k = static_cast<std::size_t>(j) * size + i;
        const double light = s.gain * (1 + s.slope_x * (i - half_) + s.slope_y * (j - half_));
        if (inside(w, s.centre.x + i - half_, s.centre.y + j - half_))
          rest.levels()[k] = static_cast<float>(
              (level[k] - s.ground_gain * share_.levels()[k] * below[k]) / light - standing_.levels()[k]);
      }
    const QuinticSpline left_over(rest);
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const double rho = std::hypot(i - half_, j - half_);
        const double cover = 1 - rim_.at(rho);
        if (cover < kLeastCoverage) continue;
        const double vx = c * (i - half_) + sine * (j - half_);
        const double vy = -sine * (i - half_) + c * (j - half_);
        const int near_x = half_ + static_cast<int>(std::lround(vx));
        const int near_y = half_ + static_cast<int>(std::lround(vy));
        if (!inside(w, s.centre.x + vx, s.centre.y + vy)) continue;
        if (rho > rim_.inner() && known[static_cast<std::size_t>(near_y) * size + near_x] == 0) continue;
        const auto k = static_cast<std::size_t>(j) * size + i;
        above[k] += cover * left_over.value(half_ + vx, half_ + vy);
        weight[k] += cover * cover;
      }
  }
  // Outwards from where it is seen the texture is continued, so that its spline does not ring at the rim.
  Picture known_here(size, size);
  for (std::size_t k = 0; k < pixels; ++k) {
    known_here.levels()[k] = weight[k] > 0 ? 1.0F : 0.0F;
    texture_.levels()[k] = weight[k] > 0 ? static_cast<float>(above[k] / weight[k]) : 0.0F;
  }
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      if (known_here.at(i, j) > 0) continue;
      const double rho = std::hypot(i - half_, j - half_);
      for (double r = rho - 0.5; r > 0 && rho - r < 4; r -= 0.5) {
        const int x = half_ + static_cast<int>(std::lround((i - half_) * r / rho));
        const int y = half_ + static_cast<int>(std::lround((j - half_) * r / rho));
        if (known_here.at(x, y) == 0) continue;
        texture_.at(i, j) = texture_.at(x, y);
        break;
      }
    }
  texture_spline_ = QuinticSpline(texture_);
}

void LayeredDisc::learn(std::vector<KeptWindow>& windows, const GroundPicture& ground,
                        double noise_variance) {
  double gain = 0;
  double slope_x = 0;
  double slope_y = 0;
  for (const KeptWindow& w : windows) {
    const auto n = static_cast<double>(windows.size());
    gain += w.state.gain / n;
    slope_x += w.state.slope_x / n;
    slope_y += w.state.slope_y / n;
  }
  for (KeptWindow& w : windows) {
    w.state.gain /= gain;
    w.state.slope_x -= slope_x;
    w.state.slope_y -= slope_y;
  }
  learn_standing(windows, ground, noise_variance, true);
  if (!turning_) return;
  for (int k = 0; k < kBackfits; ++k) {
    learn_turning(windows, ground);
    learn_standing(windows, ground, noise_variance, k + 1 == kBackfits);
  }
}

}  // namespace tribotrack::vision
