#include "vision/noise_estimate.h"

#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr int kBlock = 16;     ///< of a single picture
constexpr int kPairBlock = 8;  ///< of a difference of two: small, so that few of them hold something moving
constexpr double kRounding = 1.0 / 12;

double median_of(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Mean over the blocks about the median that noise alone explains: what moves raises a block far beyond the
/// scatter of such an estimate, and the median of all with it.
double usual_of(std::vector<double>& blocks) {
  constexpr double kScatter = 0.178;  // sqrt(2 / (64 - 1))
  constexpr double kCut = 0.0177;     // phi(2.5) / Phi(2.5): the mean below 2.5 sd, in sd
  double estimate = median_of(blocks);
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

}  // namespace

double noise_variance(const std::vector<Picture>& consecutive) {
  double sum = 0;
  int pairs = 0;
  for (std::size_t k = 0; k + 1 < consecutive.size(); ++k) {
    const Picture& a = consecutive[k];
    const Picture& b = consecutive[k + 1];
    std::vector<double> blocks;
    for (int y0 = 0; y0 + kPairBlock <= a.height(); y0 += kPairBlock)
      for (int x0 = 0; x0 + kPairBlock <= a.width(); x0 += kPairBlock) {
        double s = 0;
        double q = 0;
        for (int y = y0; y < y0 + kPairBlock; ++y)
          for (int x = x0; x < x0 + kPairBlock; ++x) {
            const double d = static_cast<double>(a.at(x, y)) - b.at(x, y);
            s += d;
            q += d * d;
          }
        constexpr double n = kPairBlock * kPairBlock;
        const double variance = (q - s * s / n) / (n - 1) / 2;
        if (variance > 0) blocks.push_back(variance);  // 0: black, clipped, or a repeated frame
      }
    if (blocks.empty()) continue;
    sum += usual_of(blocks);
    ++pairs;
  }
  double variance = pairs > 0 ? sum / pairs : 0;
  if (!consecutive.empty()) {
    // A texture that moves everywhere inflates the differences, a standing one the single picture.
    const double single = noise_variance(consecutive.front());
    variance = pairs > 0 ? std::min(variance, 1.1 * single) : single;
  }
  return std::max(variance, kRounding);
}

double noise_variance(const Picture& picture) {
  std::vector<double> blocks;
  for (int y0 = 1; y0 + kBlock < picture.height(); y0 += kBlock)
    for (int x0 = 1; x0 + kBlock < picture.width(); x0 += kBlock) {
      double q = 0;
      for (int y = y0; y < y0 + kBlock; ++y)
        for (int x = x0; x < x0 + kBlock; ++x) {
          const auto row = [&](int dy) {
            return static_cast<double>(picture.at(x - 1, y + dy)) - 2.0 * picture.at(x, y + dy) +
                   picture.at(x + 1, y + dy);
          };
          const double d = row(-1) - 2 * row(0) + row(1);
          q += d * d;
        }
      if (q > 0) blocks.push_back(q / (36.0 * kBlock * kBlock));
    }
  return std::max(median_of(blocks), kRounding);
}

}  // namespace tribotrack::vision
