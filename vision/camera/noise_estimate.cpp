#include "vision/camera/noise_estimate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "vision/kernels/median.h"
#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr int kBlock = 16;     ///< of a single picture
constexpr int kPairBlock = 8;  ///< of a difference of two: small, so that few of them hold something moving
/// Of a picture, at least: a variance's estimate from so many blocks scatters by less than half a percent.
constexpr int kEnoughBlocks = 4000;
constexpr double kRounding = 1.0 / 12;

/// Mean over the blocks about the median that noise alone explains: what moves raises a block far beyond the
/// scatter of such an estimate, and the median of all with it.
double usual_of(std::vector<double>& blocks) {
  constexpr double kScatter = 0.178;  // sqrt(2 / (64 - 1))
  constexpr double kCut = 0.0177;     // phi(2.5) / Phi(2.5): the mean below 2.5 sd, in sd
  double estimate = median(blocks);
  for (int round = 0; round < 10; ++round) {
    double sum = 0, count = 0;
    for (const double b : blocks)
      if (b < (1 + 2.5 * kScatter) * estimate && b > (1 - 4 * kScatter) * estimate) {
        sum += b;
        ++count;
      }
    if (count == 0) break;
    estimate = sum / count / (1 - kCut * kScatter);
  }
  return estimate;
}

/// Sums of the differences and of their squares over 8 x 8 px blocks next to each other: first down the
/// columns, which is exact for whole levels and goes eight columns at a time.
TRIBOTRACK_CLONES void add_difference(const float* a, const float* b, std::size_t n, double* sums,
                                      double* squares) {
  for (std::size_t i = 0; i < n; ++i) {
    const double d = static_cast<double>(a[i]) - static_cast<double>(b[i]);
    sums[i] += d;
    squares[i] += d * d;
  }
}

/// Squares of (1, -2, 1) down and across.
TRIBOTRACK_CLONES void add_bends(const float* above, const float* here, const float* below, std::size_t n,
                                 double* squares) {
  const auto down = [&](std::size_t i) {
    return static_cast<double>(above[i]) - 2.0 * static_cast<double>(here[i]) + static_cast<double>(below[i]);
  };
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double d = down(i - 1) - 2 * down(i) + down(i + 1);
    squares[i] += d * d;
  }
}

double total(const double* from, int count) {
  return std::accumulate(from, from + count, 0.0);
}

/// Of so many rows of blocks one is looked at: a large picture holds more than are needed.
int row_stride(const Picture& picture, int block) {
  return std::max(1, picture.width() / block * (picture.height() / block) / kEnoughBlocks);
}

}  // namespace

void NoiseEstimate::add_pair(const Picture& a, const Picture& b) {
  std::vector<double> blocks;
  const auto width = static_cast<std::size_t>(a.width());
  std::vector<double> sums(width), squares(width);
  // Each pair looks at other rows.
  const int stride = row_stride(a, kPairBlock);
  for (int y0 = pairs_ % stride * kPairBlock; y0 + kPairBlock <= a.height(); y0 += stride * kPairBlock) {
    std::ranges::fill(sums, 0.0);
    std::ranges::fill(squares, 0.0);
    for (int y = y0; y < y0 + kPairBlock; ++y)
      add_difference(a.row(y).data(), b.row(y).data(), width, sums.data(), squares.data());
    for (int x0 = 0; x0 + kPairBlock <= a.width(); x0 += kPairBlock) {
      const double s = total(sums.data() + x0, kPairBlock), q = total(squares.data() + x0, kPairBlock);
      constexpr double n = kPairBlock * kPairBlock;
      const double variance = (q - s * s / n) / (n - 1) / 2;
      if (variance > 0) blocks.push_back(variance);  // 0: black, clipped, or a repeated frame
    }
  }
  if (blocks.empty()) return;
  sum_ += usual_of(blocks);
  ++pairs_;
}

double NoiseEstimate::variance(const Picture& first) const {
  // A texture that moves everywhere inflates the differences, a standing one the single picture.
  const double single = noise_variance(first);
  return std::max(pairs_ > 0 ? std::min(sum_ / pairs_, 1.1 * single) : single, kRounding);
}

double noise_variance(const std::vector<Picture>& consecutive) {
  if (consecutive.empty()) return kRounding;
  NoiseEstimate estimate;
  for (std::size_t k = 0; k + 1 < consecutive.size(); ++k)
    estimate.add_pair(consecutive[k], consecutive[k + 1]);
  return estimate.variance(consecutive.front());
}

double noise_variance(const Picture& picture) {
  std::vector<double> blocks;
  std::vector<double> squares(static_cast<std::size_t>(picture.width()));
  const int stride = row_stride(picture, kBlock / 2);
  for (int y0 = 1; y0 + kBlock < picture.height(); y0 += stride * kBlock) {
    std::ranges::fill(squares, 0.0);
    for (int y = y0; y < y0 + kBlock; ++y)
      add_bends(picture.row(y - 1).data(), picture.row(y).data(), picture.row(y + 1).data(), squares.size(),
                squares.data());
    for (int x0 = 1; x0 + kBlock < picture.width(); x0 += kBlock)
      if (const double q = total(squares.data() + x0, kBlock); q > 0)
        blocks.push_back(q / (36.0 * kBlock * kBlock));
  }
  return std::max(median(blocks), kRounding);
}

}  // namespace tribotrack::vision
