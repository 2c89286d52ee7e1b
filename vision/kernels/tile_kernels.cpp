#include "vision/kernels/tile_kernels.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "vision/kernels/plane.h"
#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

using Lanes = VectorOf<float, kTile>::type;  // a row of a tile

TRIBOTRACK_KERNEL void sample_with(const std::vector<const float*>& corners, std::ptrdiff_t stride,
                                   const SplineTaps& taps, float pivot, bool slopes, TileArrays& arrays,
                                   std::size_t tile, std::size_t end) {
  constexpr int kRows = kTile + 5;
  for (std::size_t t = tile; t < end; ++t) {
    Lanes smooth[kRows], slanted[kRows];
    for (int j = 0; j < kRows; ++j) {
      const float* c = corners[t] + (j - 2) * stride - 2;
      Lanes a{}, b{};
      for (std::size_t k = 0; k < 6; ++k) {
        Lanes v;
        load(c + k, v);
        a += taps.weight_x[k] * v;
        if (slopes) b += taps.slope_x[k] * v;
      }
      smooth[j] = a;
      slanted[j] = b;
    }
    for (int j = 0; j < kTile; ++j) {
      const std::size_t at = t * kTilePixels + static_cast<std::size_t>(j * kTile);
      Lanes value{}, x{}, y{};
      for (int k = 0; k < 6; ++k) {
        const auto i = static_cast<std::size_t>(k);
        value += taps.weight_y[i] * smooth[j + k];
        if (!slopes) continue;
        x += taps.weight_y[i] * slanted[j + k];
        y += taps.slope_y[i] * smooth[j + k];
      }
      store(value - pivot, arrays.value.data() + at);
      if (!slopes) continue;
      store(x, arrays.slope_x.data() + at);
      store(y, arrays.slope_y.data() + at);
    }
  }
}

template <int columns>
TRIBOTRACK_KERNEL NormalSums normal_with(const TileArrays& arrays, std::size_t tile, std::size_t end) {
  constexpr int kSums = columns * (columns + 1) / 2;
  Lanes total[kSums] = {};
  for (std::size_t i = tile * kTilePixels; i < end * kTilePixels; i += kTile) {
    Lanes w, column[columns], one = Lanes{} + 1.0F;
    load(arrays.weight.data() + i, w);
    load(arrays.slope_x.data() + i, column[0]);
    load(arrays.slope_y.data() + i, column[1]);
    load(arrays.value.data() + i, column[2]);
    column[0] = -column[0];
    column[1] = -column[1];
    column[3] = one;
    if constexpr (columns == 5) load(arrays.slope_theta.data() + i, column[4]);
    for (int c = 0, k = 0; c < columns; ++c) {
      const Lanes weighted = w * column[c];
      for (int d = c; d < columns; ++d, ++k) total[k] += weighted * column[d];
    }
  }
  NormalSums out{};
  for (int k = 0; k < kSums; ++k) out[static_cast<std::size_t>(k)] = sum(total[k]);
  return out;
}

}  // namespace

TRIBOTRACK_CLONES void sample_tiles(const std::vector<const float*>& corners, std::ptrdiff_t stride,
                                    const SplineTaps& taps, float pivot, bool slopes, TileArrays& arrays,
                                    std::size_t tile, std::size_t end) {
  end = std::min(end, corners.size());
  slopes ? sample_with(corners, stride, taps, pivot, true, arrays, tile, end)
         : sample_with(corners, stride, taps, pivot, false, arrays, tile, end);
}

bool take_levels(const Picture& picture, int left, int top, const std::vector<TilePlace>& tiles, float pivot,
                 std::vector<float>& level, std::vector<float>& weight) {
  bool all_inside = true;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const int x = left + tiles[t].x, y = top + tiles[t].y;
    const bool inside = x >= 0 && y >= 0 && x + kTile <= picture.width() && y + kTile <= picture.height();
    all_inside &= inside;
    for (int j = 0; j < kTile; ++j) {
      float* to = level.data() + t * kTilePixels + static_cast<std::size_t>(j * kTile);
      if (inside) {
        const float* from = picture.row(y + j).data() + x;
        for (int i = 0; i < kTile; ++i) to[i] = from[i] - pivot;
        continue;
      }
      float* counts = weight.data() + t * kTilePixels + static_cast<std::size_t>(j * kTile);
      for (int i = 0; i < kTile; ++i) {
        const bool seen = x + i >= 0 && x + i < picture.width() && y + j >= 0 && y + j < picture.height();
        to[i] = seen ? picture.at(x + i, y + j) - pivot : 0.0F;
        if (!seen) counts[i] = 0;
      }
    }
  }
  return all_inside;
}

TRIBOTRACK_CLONES ForceSums force_sums(const TileArrays& arrays, float a, float b, std::size_t tile,
                                       std::size_t end) {
  const bool turns = !arrays.slope_theta.empty();
  end = std::min(end, arrays.tiles);
  Lanes fx{}, fy{}, fv{}, f1{}, ft{}, squares{}, weight{}, largest{};
  for (std::size_t i = tile * kTilePixels; i < end * kTilePixels; i += kTile) {
    Lanes v, l, w, x, y;
    load(arrays.value.data() + i, v);
    load(arrays.level.data() + i, l);
    load(arrays.weight.data() + i, w);
    load(arrays.slope_x.data() + i, x);
    load(arrays.slope_y.data() + i, y);
    const Lanes r = l - a * v - b, wr = w * r;
    fx -= wr * x;
    fy -= wr * y;
    fv += wr * v;
    f1 += wr;
    if (turns) {
      Lanes s;
      load(arrays.slope_theta.data() + i, s);
      ft += wr * s;
    }
    squares += wr * r;
    weight += w;
    const Lanes size = r < 0 ? -r : r, counted = w > 0 ? size : Lanes{};
    largest = counted > largest ? counted : largest;
  }
  ForceSums out;
  out.force = {sum(fx), sum(fy), sum(fv), sum(f1), sum(ft)};
  out.squares = sum(squares);
  out.weight = sum(weight);
  for (int i = 0; i < kTile; ++i) out.largest = std::fmax(out.largest, static_cast<double>(largest[i]));
  return out;
}

TRIBOTRACK_CLONES NormalSums normal_sums(const TileArrays& arrays, std::size_t tile, std::size_t end) {
  end = std::min(end, arrays.tiles);
  return arrays.slope_theta.empty() ? normal_with<4>(arrays, tile, end) : normal_with<5>(arrays, tile, end);
}

TRIBOTRACK_CLONES CorrelationSums correlation_sums(const TileArrays& arrays,
                                                   const std::vector<float>& weight) {
  Lanes sw{}, sv{}, sl{}, svv{}, sll{}, svl{};
  for (std::size_t i = 0; i < arrays.tiles * kTilePixels; i += kTile) {
    Lanes v, l, w;
    load(arrays.value.data() + i, v);
    load(arrays.level.data() + i, l);
    load(weight.data() + i, w);
    const Lanes wv = w * v, wl = w * l;
    sw += w;
    sv += wv;
    sl += wl;
    svv += wv * v;
    sll += wl * l;
    svl += wv * l;
  }
  return {sum(sw), sum(sv), sum(sl), sum(svv), sum(sll), sum(svl)};
}

double CorrelationSums::correlation() const {
  if (w <= 0) return 0;
  const double spread = (vv - v * v / w) * (ll - l * l / w);
  return spread > 1e-9 ? (vl - v * l / w) / std::sqrt(spread) : 0;
}

void TileArrays::resize(std::size_t count) {
  tiles = count;
  for (auto* v : {&value, &slope_x, &slope_y, &level, &weight}) v->resize(count * kTilePixels);
}

namespace {

constexpr int kReach = 2;  ///< the average is over 2 kReach + 1 pixels each way
/// The mean of 25 squares of noise gradients, themselves correlated, scatters by a third of their
/// expectation: four times that.
constexpr double kStandsOut = 1.3;
constexpr double kShare = 0.995;  ///< of the information above the noise that is kept

/// Sums over (2 kReach + 1)^2 pixels, fewer at the border.
Picture box_sums(const Picture& in) {
  Picture out = in;
  cv::boxFilter(matrix_of(in), matrix_of(out), -1, {2 * kReach + 1, 2 * kReach + 1}, {-1, -1}, false,
                cv::BORDER_CONSTANT);
  return out;
}

/// The largest threshold on `density` above which at least `share` of the information lies.
float threshold(const Picture& density, const Picture& information, double least, double share) {
  std::vector<std::pair<float, double>> candidates;
  double total = 0;
  for (std::size_t k = 0; k < density.levels().size(); ++k) {
    if (!(density.levels()[k] > least)) continue;
    candidates.emplace_back(density.levels()[k], information.levels()[k]);
    total += information.levels()[k];
  }
  std::sort(candidates.begin(), candidates.end(), std::greater<>());
  double kept = 0;
  for (const auto& [level, gain] : candidates) {
    kept += gain;
    if (kept >= share * total) return level;
  }
  return static_cast<float>(least);
}

}  // namespace

Picture informative_pixels(const Picture& slope_x, const Picture& slope_y, const Picture& weights,
                           double noise_square) {
  Picture information(weights.width(), weights.height());
  for (std::size_t k = 0; k < weights.levels().size(); ++k) {
    const float gx = slope_x.levels()[k], gy = slope_y.levels()[k];
    information.levels()[k] =
        weights.levels()[k] > 0 ? gx * gx + gy * gy - static_cast<float>(noise_square) : 0.0F;
  }
  const Picture sums = box_sums(information), counts = box_sums(weights);
  Picture density(weights.width(), weights.height());
  for (std::size_t k = 0; k < weights.levels().size(); ++k)
    if (weights.levels()[k] > 0) density.levels()[k] = sums.levels()[k] / counts.levels()[k];
  const float level = threshold(density, information, kStandsOut * noise_square, kShare);
  Picture mask(weights.width(), weights.height());
  bool any = false;
  for (std::size_t k = 0; k < weights.levels().size(); ++k)
    if (weights.levels()[k] > 0 && density.levels()[k] >= level && density.levels()[k] > 0) {
      mask.levels()[k] = weights.levels()[k];
      any = true;
    }
  return any ? mask : weights;
}

std::vector<TilePlace> cover_with_tiles(const Picture& mask) {
  std::vector<TilePlace> tiles;
  for (int y = 0; y < mask.height(); y += kTile) {
    const auto counts = [&](int x) {
      for (int j = y; j < std::min(y + kTile, mask.height()); ++j)
        if (mask.at(x, j) > 0) return true;
      return false;
    };
    for (int x = 0; x < mask.width();)
      if (counts(x)) {
        tiles.push_back({x, y});
        x += kTile;
      } else {
        ++x;
      }
  }
  return tiles;
}

std::vector<float> under_tiles(const Picture& mask, const std::vector<TilePlace>& tiles) {
  std::vector<float> out;
  for (const TilePlace& t : tiles)
    for (int y = t.y; y < t.y + kTile; ++y)
      for (int x = t.x; x < t.x + kTile; ++x)
        out.push_back(x < mask.width() && y < mask.height() ? mask.at(x, y) : 0.0F);
  return out;
}

namespace {

void spread_outliers(std::span<const TilePlace> places, std::vector<unsigned char>& outliers) {
  constexpr int kEdge = 3;  // px about a covering object that are half covered
  if (std::ranges::count(outliers, 0) == std::ssize(outliers)) return;
  const auto columns = std::ranges::minmax(places, {}, &TilePlace::x);
  const auto rows = std::ranges::minmax(places, {}, &TilePlace::y);
  const int left = columns.min.x - kEdge, top = rows.min.y - kEdge;
  cv::Mat map(rows.max.y - top + kTile + kEdge, columns.max.x - left + kTile + kEdge, CV_8U, cv::Scalar(0));
  const auto each = [&](const auto& act) {
    for (std::size_t t = 0; t < places.size(); ++t)
      for (int j = 0; j < kTile; ++j)
        for (int i = 0; i < kTile; ++i)
          act(outliers[t * kTilePixels + static_cast<std::size_t>(j * kTile + i)],
              map.at<unsigned char>(places[t].y - top + j, places[t].x - left + i));
  };
  each([](unsigned char outlier, unsigned char& place) { place = outlier != 0; });
  cv::Mat around, together, disc(2 * kEdge + 1, 2 * kEdge + 1, CV_8U, cv::Scalar(0));
  cv::boxFilter(map, around, -1, {3, 3}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::min(map, around >= 3, together);
  cv::circle(disc, {kEdge, kEdge}, kEdge, cv::Scalar(1), cv::FILLED);
  cv::dilate(together, together, disc);
  map |= together;
  each([](unsigned char& outlier, unsigned char place) { outlier = place; });
}

}  // namespace

std::size_t leave_out(std::span<const TilePlace> places, std::vector<unsigned char> outliers, bool spread,
                      std::span<float> weights) {
  if (spread) spread_outliers(places, outliers);
  std::size_t count = 0;
  for (std::size_t i = 0; i < outliers.size(); ++i) {
    if (outliers[i] == 0 || !(weights[i] > 0)) continue;
    weights[i] = 0;
    ++count;
  }
  return count;
}

}  // namespace tribotrack::vision
