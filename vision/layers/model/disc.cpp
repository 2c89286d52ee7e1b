#include "vision/layers/model/disc.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

namespace tribotrack::vision {
namespace {

constexpr int kContext = 2;         ///< px of grid beyond the rim's reach
constexpr double kTurnStep = 0.25;  ///< px at the rim: frames turned by less are averaged
constexpr double kTextureSd = 20;   ///< grey levels a disc's texture may have
constexpr int kSplitIterations = 30;

}  // namespace

int LayeredDisc::half_of(double radius, double blur) {
  return static_cast<int>(std::ceil(RimProfile(radius, blur).outer())) + kContext;
}

void as_seen(const KeptWindow& window, int left, int top, int width, int height, float* levels) {
  if (window.partly_unseen) {
    const QuinticSpline passing = window.spline;
    return passing.sample_window(left, top, width, height, levels, nullptr, nullptr);
  }
  for (int y = 0; y < height; ++y, levels += width)
    std::copy_n(window.picture.row(top + y).begin() + left, width, levels);
}

LayeredDisc::LayeredDisc(double radius, double blur, bool turning)
    : radius_(radius), turning_(turning), rim_(radius, blur), half_(half_of(radius, blur)) {
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
  const auto c = static_cast<float>(std::cos(theta)), s = static_cast<float>(std::sin(theta));
  const auto middle = static_cast<float>(half_);
  std::vector<std::size_t> covered;
  std::vector<float> x, y;
  for (std::size_t k = 0; k < share_.levels().size(); ++k) {
    if (share_.levels()[k] >= 1) continue;
    const auto size = static_cast<std::size_t>(share_.width());
    const float u = static_cast<float>(k % size) - middle, v = static_cast<float>(k / size) - middle;
    covered.push_back(k);
    x.push_back(middle + c * u - s * v);
    y.push_back(middle + s * u + c * v);
  }
  std::vector<float> value(covered.size()), slope_x(covered.size()), slope_y(covered.size());
  texture_spline_.sample_places(x, y, value.data(), slope ? slope_x.data() : nullptr, slope_y.data());
  for (std::size_t i = 0; i < covered.size(); ++i) {
    const float cover = 1 - share_.levels()[covered[i]];
    out.levels()[covered[i]] += cover * value[i];
    if (slope)
      slope->levels()[covered[i]] = cover * (slope_y[i] * (x[i] - middle) - slope_x[i] * (y[i] - middle));
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

/// Tiles over the rim and what is not 0 in `where`; over the whole grid without it.
std::vector<TilePlace> LayeredDisc::tiles_about_rim(const Picture* where) const {
  const int size = 2 * half_ + 1;
  Picture mask(size, size, 1);
  if (where)
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const double x = i - half_, y = j - half_, square = x * x + y * y;
        const bool rim = square >= rim_.inner() * rim_.inner() && square <= rim_.outer() * rim_.outer();
        if (!rim && where->at(i, j) == 0) mask.at(i, j) = 0;
      }
  return cover_with_tiles(mask);
}

void LayeredDisc::learn_standing(std::span<const KeptWindow> windows, const GroundPicture& ground,
                                 double noise_variance, const std::vector<TilePlace>& tiles) {
  const std::size_t pixels = tiles.size() * kTilePixels;
  Sums sums(pixels);
  TileArrays level, below;
  for (TileArrays* a : {&level, &below}) {
    a->tiles = tiles.size();
    for (auto* v : {&a->value, &a->slope_x, &a->slope_y}) v->resize(pixels);
  }
  std::vector<float> inside(pixels), known(pixels);
  std::vector<const float*> corners(tiles.size());
  const auto blend = static_cast<float>(blend_);
  const auto ground_mean = static_cast<float>(ground.mean());
  const auto on_grid = [&](const Picture& picture) {
    std::vector<float> out(pixels, 0);
    for (std::size_t t = 0; t < tiles.size(); ++t)
      for (int j = 0; j < std::min(kTile, picture.height() - tiles[t].y); ++j)
        std::copy_n(picture.row(tiles[t].y + j).begin() + tiles[t].x,
                    std::min(kTile, picture.width() - tiles[t].x),
                    out.begin() + static_cast<std::ptrdiff_t>(t * kTilePixels) + j * kTile);
    return out;
  };
  const std::vector<float> share = on_grid(share_), share_x = on_grid(share_x_), share_y = on_grid(share_y_);
  std::vector<float> u(pixels), v(pixels), turn(pixels, 0);
  for (std::size_t k = 0; k < pixels; ++k) {
    u[k] = static_cast<float>(tiles[k / kTilePixels].x - half_ + static_cast<int>(k % kTile));
    v[k] = static_cast<float>(tiles[k / kTilePixels].y - half_ + static_cast<int>(k % kTilePixels) / kTile);
  }
  for (const KeptWindow& w : windows) {
    if (!w.explained) continue;
    const LayeredState& s = w.state;
    const Place at = place(w);
    w.spline.sample_tiles(at.left - w.x, at.top - w.y, tiles, corners, false, level);
    ground.sample_tiles(at.left - s.ground.x, at.top - s.ground.y, tiles, corners, below, known);
    if (turning_) {
      Picture turned = this->at(s.theta);
      for (std::size_t i = 0; i < turned.levels().size(); ++i)
        turned.levels()[i] -= parts_.standing.levels()[i];
      turn = on_grid(turned);
    }
    // Where the window ends.
    const bool whole = !w.partly_unseen && at.first_column == 0 && at.first_row == 0 &&
                       at.last_column == 2 * half_ + 1 && at.last_row == 2 * half_ + 1;
    if (!whole)
      for (std::size_t k = 0; k < pixels; ++k) {
        const int i = static_cast<int>(u[k]) + half_, j = static_cast<int>(v[k]) + half_;
        inside[k] = i >= at.first_column && i < at.last_column && j >= at.first_row && j < at.last_row &&
                    (!w.partly_unseen || w.sees(at.left + i, at.top + j));
      }
    const auto gain = static_cast<float>(s.gain), slope_x = static_cast<float>(s.gain * s.slope_x),
               slope_y = static_cast<float>(s.gain * s.slope_y), under = static_cast<float>(s.ground_gain);
    for (std::size_t k = 0; k < pixels; ++k) {
      const float use = (share[k] > 0 ? known[k] : 1.0F) * (whole ? 1.0F : inside[k]);
      const float light = 1 / (gain + slope_x * u[k] + slope_y * v[k]);
      const float blended = under * blend * (share_x[k] * below.slope_x[k] + share_y[k] * below.slope_y[k]);
      const float y = (level.value[k] - blended) * light - turn[k];
      const float z = under * below.value[k] * light - ground_mean;
      sums.n[k] += use;
      sums.y[k] += use * y;
      sums.z[k] += use * z;
      sums.yz[k] += use * y * z;
      sums.zz[k] += use * z * z;
    }
  }
  for (std::size_t k = 0; k < pixels; ++k) {
    const double n = sums.n[k], rho = std::hypot(u[k], v[k]);
    if (n < 3 || rho <= rim_.inner() || rho >= rim_.outer()) continue;
    const double y = sums.y[k], z = sums.z[k];
    rim_.add(rho, sums.yz[k] - y * z / n, sums.zz[k] - z * z / n);
  }
  rim_.solve(noise_variance);
  make_share();
  for (std::size_t k = 0; k < pixels; ++k) {
    const int i = static_cast<int>(u[k]) + half_, j = static_cast<int>(v[k]) + half_;
    if (i > 2 * half_ || j > 2 * half_) continue;
    if (std::hypot(u[k], v[k]) >= rim_.outer()) {
      parts_.standing.at(i, j) = 0;
    } else if (sums.n[k] > 0) {
      const float mean = sums.z[k] / sums.n[k] + ground_mean;
      parts_.standing.at(i, j) = sums.y[k] / sums.n[k] - share_.at(i, j) * mean;
    }
  }
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
  const double room = std::max(8.0, kTurningBytes / (8.0 * static_cast<double>(pixels)));
  const auto wanted = std::min(static_cast<double>(windows.size()), std::floor((high - low) / step) + 1);
  const auto stride = static_cast<std::size_t>(std::ceil(wanted / room));

  std::map<std::int64_t, TurnedPicture> bins;
  std::map<std::int64_t, double> count;
  std::vector<float> level(pixels), below(pixels), known(pixels);
  for (std::size_t n = 0; n < windows.size(); n += stride) {
    const KeptWindow& w = windows[n];
    if (!w.explained) continue;
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
        if (w.partly_unseen && !w.sees(left + i, top + j)) continue;
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

void LayeredDisc::learn(std::span<KeptWindow> windows, const GroundPicture& ground, double noise_variance,
                        const Picture* where) {
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
  learn_standing(windows, ground, noise_variance, tiles_about_rim(turning_ ? nullptr : where));
  if (turning_) learn_turning(windows, ground, noise_variance);
}

}  // namespace tribotrack::vision
