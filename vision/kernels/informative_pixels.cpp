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

std::size_t spread_outliers(std::span<const TilePlace> places, std::vector<unsigned char>& outliers) {
  constexpr int kEdge = 3;  // px about a covering object that are half covered
  if (std::ranges::count(outliers, 0) == std::ssize(outliers)) return 0;
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
  std::size_t count = 0;
  each([&](unsigned char& outlier, unsigned char place) { count += outlier = place; });
  return count;
}

}  // namespace tribotrack::vision
