#include "vision/layered_disc.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

namespace tribotrack::vision {
namespace {

constexpr int kContext = 2;          ///< px of grid beyond the rim's reach
constexpr double kTurnStep = 0.25;   ///< px at the rim: frames turned by less are averaged
constexpr double kTurnBytes = 48e6;  ///< for these averages
constexpr double kTextureSd = 20;    ///< grey levels a disc's texture may have
constexpr int kSplitIterations = 30;

}  // namespace

LayeredDisc::LayeredDisc(double radius, double blur, bool turning)
    : radius_(radius), turning_(turning), rim_(radius, blur) {
  half_ = static_cast<int>(std::ceil(rim_.outer())) + kContext;
  const int size = 2 * half_ + 1;
  parts_.standing = Picture(size, size);
  parts_.turning = Picture(size, size);
  make_share();
  texture_spline_ = QuinticSpline(parts_.turning);
}

void LayeredDisc::make_share() {
  const int size = 2 * half_ + 1;
  share_ = Picture(size, size);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      share_.at(x, y) = static_cast<float>(rim_.at(std::hypot(x - half_, y - half_)));
  share_x_ = share_y_ = Picture(size, size);
  Picture value(size, size);
  QuinticSpline(share_).sample_window(0, 0, size, size, value.levels().data(), share_x_.levels().data(),
                                      share_y_.levels().data());
}

void LayeredDisc::set_standing(const Standing& known) {
  parts_.standing = known.picture;
  rim_.set_knots(known.knots);
  make_share();
}

void LayeredDisc::shift_standing(const Point& by) {
  Picture& p = parts_.standing;
  const QuinticSpline before(p);
  before.sample_window(by.x, by.y, p.width(), p.height(), p.levels().data(), nullptr, nullptr);
}

Picture LayeredDisc::at(double theta, Picture* slope) const {
  Picture out = parts_.standing;
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
  Picture out = at(middle_theta_);
  for (std::size_t i = 0; i < out.levels().size(); ++i)
    out.levels()[i] += static_cast<float>(level) * share_.levels()[i];
  return out;
}

/// Per pixel of the disc, over the frames: y what the disc shows in its own light, z the ground beneath in
/// the same light, less its mean.
struct LayeredDisc::Sums {
  std::vector<float> n, y, z, yz, zz;
  explicit Sums(std::size_t pixels)
      : n(pixels, 0), y(pixels, 0), z(pixels, 0), yz(pixels, 0), zz(pixels, 0) {}
};

/// Where the disc's grid lies in a kept window: its first pixel, and the columns and rows inside.
struct LayeredDisc::Place {
  double left, top;
  int first_column, last_column, first_row, last_row;
};

LayeredDisc::Place LayeredDisc::place(const KeptWindow& w) const {
  const int size = 2 * half_ + 1;
  const double left = w.state.centre.x - half_, top = w.state.centre.y - half_;
  const auto within = [size](double x) { return std::clamp(static_cast<int>(x), 0, size); };
  return {left,
          top,
          within(std::ceil(w.x - left)),
          within(std::floor(w.x + w.picture.width() - 1 - left) + 1),
          within(std::ceil(w.y - top)),
          within(std::floor(w.y + w.picture.height() - 1 - top) + 1)};
}

void LayeredDisc::learn_standing(std::span<const KeptWindow> windows, const GroundPicture& ground,
                                 double noise_variance) {
  const int size = 2 * half_ + 1;
  const auto pixels = static_cast<std::size_t>(size) * size;
  Sums sums(pixels);
  std::vector<float> level(pixels), below(pixels), known(pixels), below_x(pixels), below_y(pixels);
  const auto blend = static_cast<float>(blend_);
  const auto ground_mean = static_cast<float>(ground.mean());
  Picture turned;
  for (const KeptWindow& w : windows) {
    const LayeredState& s = w.state;
    const Place at = place(w);
    w.spline.sample_window(at.left - w.x, at.top - w.y, size, size, level.data(), nullptr, nullptr);
    ground.sample(at.left - s.ground.x, at.top - s.ground.y, size, size, below.data(), known.data(),
                  below_x.data(), below_y.data());
    if (turning_) {
      turned = this->at(s.theta);
      for (std::size_t i = 0; i < pixels; ++i) turned.levels()[i] -= parts_.standing.levels()[i];
    }
    for (int j = at.first_row; j < at.last_row; ++j) {
      const auto row = static_cast<std::size_t>(j) * size;
      const auto base = static_cast<float>(s.gain * (1 + s.slope_y * (j - half_)));
      const auto slope = static_cast<float>(s.gain * s.slope_x);
      const auto under = static_cast<float>(s.ground_gain);
      const float* share = share_.levels().data() + row;
      const float* share_x = share_x_.levels().data() + row;
      const float* share_y = share_y_.levels().data() + row;
      const float* turn = turning_ ? turned.levels().data() + row : nullptr;
      for (int i = at.first_column; i < at.last_column; ++i) {
        const std::size_t k = row + static_cast<std::size_t>(i);
        const float use = share[i] > 0 ? known[k] : 1.0F;
        const float light = 1 / (base + slope * static_cast<float>(i - half_));
        const float blended = under * blend * (share_x[i] * below_x[k] + share_y[i] * below_y[k]);
        const float y = (level[k] - blended) * light - (turn ? turn[i] : 0.0F);
        const float z = under * below[k] * light - ground_mean;
        sums.n[k] += use;
        sums.y[k] += use * y;
        sums.z[k] += use * z;
        sums.yz[k] += use * y * z;
        sums.zz[k] += use * z * z;
      }
    }
  }
  const auto each_pixel = [&](const auto& act) {
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const auto k = static_cast<std::size_t>(j) * size + i;
        const double rho = std::hypot(i - half_, j - half_);
        act(k, rho);
      }
  };
  each_pixel([&](std::size_t k, double rho) {
    const double n = sums.n[k];
    if (n < 3 || rho <= rim_.inner() || rho >= rim_.outer()) return;
    const double y = sums.y[k], z = sums.z[k];
    rim_.add(rho, sums.yz[k] - y * z / n, sums.zz[k] - z * z / n);
  });
  rim_.solve(noise_variance);
  make_share();
  each_pixel([&](std::size_t k, double rho) {
    if (rho >= rim_.outer()) {
      parts_.standing.levels()[k] = 0;
    } else if (sums.n[k] > 0) {
      const float mean = sums.z[k] / sums.n[k] + ground_mean;
      parts_.standing.levels()[k] = sums.y[k] / sums.n[k] - share_.levels()[k] * mean;
    }
  });
}

/// Frames of nearly the same rotation are averaged before the disc's picture is split: a quarter of a pixel
/// at the rim does not matter. Where that makes too many pictures for the memory, some frames are left out.
void LayeredDisc::learn_turning(std::span<const KeptWindow> windows, const GroundPicture& ground,
                                double noise_variance) {
  const int size = 2 * half_ + 1;
  const auto pixels = static_cast<std::size_t>(size) * size;
  double low = windows.front().state.theta;
  double high = low;
  for (const KeptWindow& w : windows) {
    low = std::min(low, w.state.theta);
    high = std::max(high, w.state.theta);
  }
  middle_theta_ = 0.5 * (low + high);
  const double step = kTurnStep / radius_;
  const double room = std::max(8.0, kTurnBytes / (8.0 * static_cast<double>(pixels)));
  const auto wanted = std::min(static_cast<double>(windows.size()), std::floor((high - low) / step) + 1);
  const auto stride = static_cast<std::size_t>(std::ceil(wanted / room));

  std::map<std::int64_t, TurnedPicture> bins;
  std::map<std::int64_t, double> count;
  std::vector<float> level(pixels), below(pixels), known(pixels);
  for (std::size_t n = 0; n < windows.size(); n += stride) {
    const KeptWindow& w = windows[n];
    const LayeredState& s = w.state;
    const double left = s.centre.x - half_;
    const double top = s.centre.y - half_;
    w.spline.sample_window(left - w.x, top - w.y, size, size, level.data(), nullptr, nullptr);
    ground.sample(left - s.ground.x, top - s.ground.y, size, size, below.data(), known.data());
    const Place inside = place(w);
    const auto bin = static_cast<std::int64_t>(std::floor((s.theta - low) / step));
    TurnedPicture& turned = bins[bin];
    if (turned.level.empty()) turned = {0, Picture(size, size), Picture(size, size)};
    turned.theta += s.theta;
    count[bin] += 1;
    for (int j = inside.first_row; j < inside.last_row; ++j)
      for (int i = inside.first_column; i < inside.last_column; ++i) {
        const auto k = static_cast<std::size_t>(j) * size + i;
        const float share = share_.levels()[k];
        if (share >= 1 || (share > 0 && known[k] == 0)) continue;
        const double light = s.gain * (1 + s.slope_x * (i - half_) + s.slope_y * (j - half_));
        turned.level.levels()[k] += static_cast<float>((level[k] - s.ground_gain * share * below[k]) / light);
        turned.weight.levels()[k] += 1;
      }
  }
  std::vector<TurnedPicture> pictures;
  for (auto& [bin, turned] : bins) {
    turned.theta /= count[bin];
    for (std::size_t k = 0; k < pixels; ++k)
      if (turned.weight.levels()[k] > 0) turned.level.levels()[k] /= turned.weight.levels()[k];
    pictures.push_back(std::move(turned));
  }
  Picture cover = share_;
  for (float& c : cover.levels()) c = std::max(0.0F, 1 - c);
  split_turning(pictures, cover, noise_variance / (kTextureSd * kTextureSd), rim_.inner() - 1,
                kSplitIterations, parts_);
  texture_spline_ = QuinticSpline(parts_.turning);
}

void LayeredDisc::learn(std::span<KeptWindow> windows, const GroundPicture& ground, double noise_variance) {
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
  learn_standing(windows, ground, noise_variance);
  if (turning_) learn_turning(windows, ground, noise_variance);
}

}  // namespace tribotrack::vision
