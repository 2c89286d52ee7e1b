#include "vision/layers/model/part_sums.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "vision/kernels/informative_pixels.h"
#include "vision/kernels/parallel.h"
#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kBlock = 8;  ///< tiles whose sums stay in the cache
constexpr std::size_t kBlockPixels = kBlock * kTilePixels;

/// Some tiles of a window on the part's grid.
struct WindowTiles {
  const float *level, *below, *below_x, *below_y;  ///< I, G - mean G and its slopes
  const float *unsure, *counts;                    ///< var G, 1 where the window shows the place
  const float *u, *v, *part, *share, *variance;    ///< of before
  const float *share_x, *share_y;
  float gain, slope_x, slope_y, under, mean;
  float passed, trim, blend;  ///< of white noise, squared sd, kappa
};

struct SumTiles {
  float *count, *passed, *aa, *ah, *hh, *ay, *hy, *yy, *qr, *qq;
};

TRIBOTRACK_CLONES
void add_tiles(const WindowTiles& window, const SumTiles& sums, std::size_t count) {
  const WindowTiles w = window;  // what the loop writes does not change these
  const SumTiles s = sums;
#pragma GCC ivdep
  for (std::size_t i = 0; i < count; ++i) {
    const float a = w.gain + w.slope_x * w.u[i] + w.slope_y * w.v[i];
    const float h = w.under * (w.below[i] + w.mean) - a * w.mean;
    const float q = w.under * (w.share_x[i] * w.below_x[i] + w.share_y[i] * w.below_y[i]);
    const float y = w.level[i] - a * w.part[i] - w.blend * q, r = y - w.share[i] * h;
    const float seen = w.share[i] * w.under, sd2 = w.variance[i] + seen * seen * w.unsure[i];
    const float ok = r * r > w.trim * sd2 ? 0.0F : w.counts[i], once = ok / sd2;
    const float weight = once * w.variance[i], weight_a = weight * a, weight_h = weight * h;
    s.count[i] += ok;
    s.passed[i] += ok * w.passed;
    s.aa[i] += weight_a * a;
    s.ah[i] += weight_a * h;
    s.hh[i] += weight_h * h;
    s.ay[i] += weight_a * y;
    s.hy[i] += weight_h * y;
    s.yy[i] += weight * y * y;
    s.qr[i] += once * q * r;
    s.qq[i] += once * q * q;
  }
}

}  // namespace

struct PartTileSums::Workspace {
  TileArrays level, ground;
  std::vector<float> unsure, counts;
  std::vector<const float*> corners;
  Workspace() : unsure(kBlockPixels), counts(kBlockPixels), corners(kBlock) {
    level.value.resize(kBlockPixels);
    for (auto* of : {&ground.value, &ground.slope_x, &ground.slope_y}) of->resize(kBlockPixels);
  }
};

struct PartTileSums::Placed {
  int x = 0, y = 0;                ///< whole px of the grid's first place in the window
  int ground_x = 0, ground_y = 0;  ///< and on the ground's picture
  int near_x = 0, near_y = 0;      ///< the same, rounded
  SplineTaps taps, ground_taps;
  float passed = 1;
};

PartTileSums::PartTileSums(const PartPictures& before, const GroundPicture& ground)
    : before_(before),
      ground_(ground),
      tiles_(cover_with_tiles(Picture(2 * before.half + 1, 2 * before.half + 1, 1.0F))) {
  const int size = 2 * before.half + 1;
  const std::size_t n = tiles_.size() * kTilePixels;
  for (auto* of : {&u_, &v_, &on_grid_}) of->resize(n);
  for (std::size_t t = 0; t < tiles_.size(); ++t)
    for (std::size_t k = 0; k < kTilePixels; ++k) {
      const int i = tiles_[t].x + static_cast<int>(k % kTile), j = tiles_[t].y + static_cast<int>(k / kTile);
      const std::size_t at = t * kTilePixels + k;
      u_[at] = static_cast<float>(i - before.half);
      v_[at] = static_cast<float>(j - before.half);
      on_grid_[at] = i < size && j < size ? 1.0F : 0.0F;
    }
  Picture value(size, size), slope_x(size, size), slope_y(size, size);
  QuinticSpline(before.share)
      .sample_window(0, 0, size, size, value.levels().data(), slope_x.levels().data(),
                     slope_y.levels().data());
  level_ = in_tiles(before.level);
  share_ = in_tiles(before.share);
  variance_ = in_tiles(before.variance);
  share_x_ = in_tiles(slope_x);
  share_y_ = in_tiles(slope_y);
  for (auto& sums : sums_) sums.assign(n, 0);
}

std::vector<float> PartTileSums::in_tiles(const Picture& picture) const {
  std::vector<float> out(tiles_.size() * kTilePixels);
  for (std::size_t t = 0; t < tiles_.size(); ++t)
    for (std::size_t k = 0; k < kTilePixels; ++k)
      out[t * kTilePixels + k] =
          picture.at(std::min(tiles_[t].x + static_cast<int>(k % kTile), picture.width() - 1),
                     std::min(tiles_[t].y + static_cast<int>(k / kTile), picture.height() - 1));
  return out;
}

PartTileSums::Placed PartTileSums::placed(const KeptWindow& window) const {
  const LayeredState& s = window.state;
  const double left = s.centre.x - before_.half - window.x, top = s.centre.y - before_.half - window.y;
  const double ground_left = s.centre.x - before_.half - s.ground.x - ground_.region().x,
               ground_top = s.centre.y - before_.half - s.ground.y - ground_.region().y;
  const auto whole = [](double place) { return static_cast<int>(std::floor(place)); };
  Placed out;
  out.x = whole(left);
  out.y = whole(top);
  out.ground_x = whole(ground_left);
  out.ground_y = whole(ground_top);
  out.near_x = static_cast<int>(std::lround(ground_left));
  out.near_y = static_cast<int>(std::lround(ground_top));
  out.taps = spline_taps(left - out.x, top - out.y);
  out.ground_taps = spline_taps(ground_left - out.ground_x, ground_top - out.ground_y);
  out.passed = static_cast<float>(quintic_noise(left - out.x).value * quintic_noise(top - out.y).value);
  return out;
}

/// What the window shows at these tiles, and where it shows nothing.
void PartTileSums::take_window(std::size_t first, std::size_t count, const KeptWindow& window,
                               const Placed& at, Workspace& work) const {
  const int width = window.picture.width(), height = window.picture.height();
  work.corners.resize(count);
  for (std::size_t t = 0; t < count; ++t) {
    const TilePlace& tile = tiles_[first + t];
    const int left = at.x + tile.x, top = at.y + tile.y;
    work.corners[t] = window.spline.coefficient(std::clamp(left, -8, width), std::clamp(top, -8, height));
    float* counts = work.counts.data() + t * kTilePixels;
    std::memcpy(counts, on_grid_.data() + (first + t) * kTilePixels, kTilePixels * sizeof(float));
    // Between the first and the last pixel of the window.
    if (left < 0 || top < 0 || left + kTile > width - 1 || top + kTile > height - 1)
      for (int j = 0; j < kTile; ++j)
        for (int i = 0; i < kTile; ++i)
          if (left + i < 0 || top + j < 0 || left + i + 1 > width - 1 || top + j + 1 > height - 1)
            counts[j * kTile + i] = 0;
  }
  work.level.tiles = count;
  sample_tiles(work.corners, window.spline.stride(), at.taps, 0, false, work.level);
}

/// The ground under these tiles, and its variance.
void PartTileSums::take_ground(std::size_t first, std::size_t count, const Placed& at,
                               Workspace& work) const {
  const Rect& region = ground_.region();
  for (std::size_t t = 0; t < count; ++t) {
    const TilePlace& tile = tiles_[first + t];
    // Far outside the ground's picture the spline is that of its border.
    work.corners[t] = ground_.spline().coefficient(std::clamp(at.ground_x + tile.x, -8, region.width),
                                                   std::clamp(at.ground_y + tile.y, -8, region.height));
    float* unsure = work.unsure.data() + t * kTilePixels;
    const int x = at.near_x + tile.x, y = at.near_y + tile.y;
    for (int j = 0; j < kTile; ++j) {
      const auto row = ground_.variance().row(std::clamp(y + j, 0, region.height - 1));
      if (x >= 0 && x + kTile <= region.width)
        std::memcpy(unsure + j * kTile, row.data() + x, kTile * sizeof(float));
      else
        for (int i = 0; i < kTile; ++i)
          unsure[j * kTile + i] = row[static_cast<std::size_t>(std::clamp(x + i, 0, region.width - 1))];
    }
  }
  work.ground.tiles = count;
  sample_tiles(work.corners, ground_.spline().stride(), at.ground_taps, 0, true, work.ground);
}

void PartTileSums::add_block(std::size_t block, const KeptWindow& window, const Placed& at, float trim,
                             Workspace& work) {
  const std::size_t first = block * kBlock, count = std::min(kBlock, tiles_.size() - first);
  take_window(first, count, window, at, work);
  take_ground(first, count, at, work);
  const LayeredState& s = window.state;
  const std::size_t from = first * kTilePixels;
  const WindowTiles tiles{work.level.value.data(),
                          work.ground.value.data(),
                          work.ground.slope_x.data(),
                          work.ground.slope_y.data(),
                          work.unsure.data(),
                          work.counts.data(),
                          u_.data() + from,
                          v_.data() + from,
                          level_.data() + from,
                          share_.data() + from,
                          variance_.data() + from,
                          share_x_.data() + from,
                          share_y_.data() + from,
                          static_cast<float>(s.gain),
                          static_cast<float>(s.gain * s.slope_x),
                          static_cast<float>(s.gain * s.slope_y),
                          static_cast<float>(s.ground_gain),
                          static_cast<float>(ground_.mean()),
                          at.passed,
                          trim,
                          static_cast<float>(before_.blend)};
  add_tiles(
      tiles,
      {sums_[kCount].data() + from, sums_[kPassed].data() + from, sums_[kAA].data() + from,
       sums_[kAH].data() + from, sums_[kHH].data() + from, sums_[kAY].data() + from, sums_[kHY].data() + from,
       sums_[kYY].data() + from, sums_[kQR].data() + from, sums_[kQQ].data() + from},
      count * kTilePixels);
}

void PartTileSums::add(WindowSpan windows, double trim, int threads) {
  std::vector<Placed> places;
  for (const KeptWindow* window : windows) places.push_back(placed(*window));
  std::vector<Workspace> work(static_cast<std::size_t>(std::max(1, threads)));
  const auto limit = static_cast<float>(trim * trim);
  parallel_for((tiles_.size() + kBlock - 1) / kBlock, threads, [&](std::size_t block, std::size_t worker) {
    for (std::size_t k = 0; k < windows.size(); ++k)
      add_block(block, *windows[k], places[k], limit, work[worker]);
  });
}

Picture PartTileSums::picture(PartSum sum) const {
  const int size = 2 * before_.half + 1;
  Picture out(size, size);
  for (std::size_t t = 0; t < tiles_.size(); ++t)
    for (std::size_t k = 0; k < kTilePixels; ++k) {
      const int i = tiles_[t].x + static_cast<int>(k % kTile), j = tiles_[t].y + static_cast<int>(k / kTile);
      if (i < size && j < size) out.at(i, j) = sums_[sum][t * kTilePixels + k];
    }
  return out;
}

}  // namespace tribotrack::vision
