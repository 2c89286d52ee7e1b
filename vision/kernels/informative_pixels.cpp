#include "vision/kernels/informative_pixels.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "vision/kernels/tile_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr int kReach = 2;  ///< the average is over 2 kReach + 1 pixels each way
/// The mean of 25 squares of noise gradients, themselves correlated, scatters by a third of their
/// expectation: four times that.
constexpr double kStandsOut = 1.3;

/// Sums over (2 kReach + 1)^2 pixels, fewer at the border.
Picture box_sums(const Picture& in) {
  Picture out = in;
  cv::Mat levels(out.height(), out.width(), CV_32F, out.levels().data());
  cv::boxFilter(levels, levels, -1, {2 * kReach + 1, 2 * kReach + 1}, {-1, -1}, false, cv::BORDER_CONSTANT);
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
                           const InformativeOptions& options) {
  Picture information(weights.width(), weights.height());
  for (std::size_t k = 0; k < weights.levels().size(); ++k) {
    const float gx = slope_x.levels()[k], gy = slope_y.levels()[k];
    information.levels()[k] =
        weights.levels()[k] > 0 ? gx * gx + gy * gy - static_cast<float>(options.noise_square) : 0.0F;
  }
  const Picture sums = box_sums(information), counts = box_sums(weights);
  Picture density(weights.width(), weights.height());
  for (std::size_t k = 0; k < weights.levels().size(); ++k)
    if (weights.levels()[k] > 0) density.levels()[k] = sums.levels()[k] / counts.levels()[k];
  const float level = threshold(density, information, kStandsOut * options.noise_square, options.share);
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

namespace {

constexpr unsigned char kOutlier = 1, kNearby = 2;

}  // namespace

std::size_t spread_outliers(std::span<const TilePlace> places, double reach,
                            std::vector<unsigned char>& outliers) {
  if (places.empty()) return 0;
  const int margin = std::max(1, static_cast<int>(reach));
  const auto columns = std::ranges::minmax(places, {}, &TilePlace::x);
  const auto rows = std::ranges::minmax(places, {}, &TilePlace::y);
  const int left = columns.min.x, top = rows.min.y;
  const int width = columns.max.x - left + kTile + 2 * margin, height = rows.max.y - top + kTile + 2 * margin;
  std::vector<unsigned char> map(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  // Row j of a tile: its first pixel in the map.
  const auto row_of = [&](const TilePlace& place, int j) {
    return static_cast<std::ptrdiff_t>(place.y - top + margin + j) * width + (place.x - left + margin);
  };
  std::vector<std::ptrdiff_t> seen;
  for (std::size_t t = 0; t < places.size(); ++t)
    for (int j = 0; j < kTile; ++j) {
      const unsigned char* row = outliers.data() + t * kTilePixels + static_cast<std::size_t>(j) * kTile;
      if (!any_in_row(row)) continue;
      for (int i = 0; i < kTile; ++i)
        if (row[i] != 0) {
          seen.push_back(row_of(places[t], j) + i);
          map[static_cast<std::size_t>(seen.back())] = kOutlier;
        }
    }
  for (const std::ptrdiff_t p : seen) {
    int together = -1;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        together += map[static_cast<std::size_t>(p + dy * width + dx)] & kOutlier;
    if (together < 2) continue;
    for (int dy = -margin; dy <= margin; ++dy)
      for (int dx = -margin; dx <= margin; ++dx)
        if (dx * dx + dy * dy <= reach * reach) map[static_cast<std::size_t>(p + dy * width + dx)] |= kNearby;
  }
  std::size_t count = 0;
  for (std::size_t t = 0; t < places.size(); ++t)
    for (int j = 0; j < kTile; ++j) {
      unsigned char* row = outliers.data() + t * kTilePixels + static_cast<std::size_t>(j) * kTile;
      const unsigned char* from = map.data() + row_of(places[t], j);
      if (!any_in_row(from)) continue;
      for (int i = 0; i < kTile; ++i) {
        row[i] = from[i] != 0;
        count += row[i];
      }
    }
  return count;
}

}  // namespace tribotrack::vision
