#include "vision/edge/bands.h"

#include <algorithm>

namespace tribotrack::vision {
namespace {

/// Frames on either side of running means, each taken three times: about Gaussian windows of 3 and 9 frames.
/// The result is not delicate in them.
constexpr std::size_t kShort = 3, kLong = 9;
constexpr int kTimes = 3;

/// Means over rows k - half .. k + half, as far as there are such.
void running_mean(std::span<float> rows, std::size_t width, std::size_t half) {
  const std::size_t n = rows.size() / width;
  const std::vector<float> before(rows.begin(), rows.end());
  std::vector<double> sum(width, 0);
  std::size_t begin = 0, end = 0;
  for (std::size_t k = 0; k < n; ++k) {
    for (; end < std::min(n, k + half + 1); ++end)
      for (std::size_t i = 0; i < width; ++i) sum[i] += before[end * width + i];
    for (; begin + half < k; ++begin)
      for (std::size_t i = 0; i < width; ++i) sum[i] -= before[begin * width + i];
    const double share = 1.0 / static_cast<double>(end - begin);
    for (std::size_t i = 0; i < width; ++i) rows[k * width + i] = static_cast<float>(share * sum[i]);
  }
}

std::vector<float> smoothed(std::vector<float> series, std::size_t width,
                            std::span<const std::size_t> block_ends, std::size_t half) {
  std::size_t begin = 0;
  for (const std::size_t end : block_ends) {
    for (int time = 0; time < kTimes; ++time)
      running_mean(std::span(series).subspan(begin * width, (end - begin) * width), width, half);
    begin = end;
  }
  return series;
}

}  // namespace

Bands split_bands(const std::vector<float>& series, std::size_t width,
                  std::span<const std::size_t> block_ends) {
  Bands bands = {series, smoothed(series, width, block_ends, kShort),
                 smoothed(series, width, block_ends, kLong)};
  for (std::size_t b = 0; b + 1 < kBands; ++b)
    for (std::size_t i = 0; i < series.size(); ++i) bands[b][i] -= bands[b + 1][i];
  return bands;
}

std::array<double, kBands> noise_shares(std::span<const std::size_t> block_ends) {
  std::array<double, kBands> shares{};
  std::size_t begin = 0;
  std::vector<std::size_t> lengths;
  for (const std::size_t end : block_ends) {
    const std::size_t n = end - begin;
    begin = end;
    // A unit in each row, one after the other; far from the ends all answers are alike.
    const std::size_t rows = std::min(n, 8 * kLong * kTimes), only[] = {rows};
    std::vector<float> units(rows * rows, 0);
    for (std::size_t k = 0; k < rows; ++k) units[k * rows + k] = 1;
    const Bands bands = split_bands(units, rows, only);
    for (std::size_t b = 0; b < kBands; ++b) {
      double squares = 0;
      for (const float v : bands[b]) squares += static_cast<double>(v) * v;
      shares[b] += squares / static_cast<double>(rows) * static_cast<double>(n) /
                   static_cast<double>(block_ends.back());
    }
  }
  return shares;
}

}  // namespace tribotrack::vision
