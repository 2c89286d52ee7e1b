#include "vision/coding/dead_zone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tribotrack::vision {
namespace {

constexpr int kBlock = 8;
using Block = std::array<double, kBlock * kBlock>;
using Basis = std::array<std::array<double, kBlock>, kBlock>;

Basis cosines() {
  Basis basis{};
  for (int k = 0; k < kBlock; ++k)
    for (int n = 0; n < kBlock; ++n)
      basis[static_cast<std::size_t>(k)][static_cast<std::size_t>(n)] =
          std::sqrt((k == 0 ? 1.0 : 2.0) / kBlock) * std::cos(std::numbers::pi * k * (n + 0.5) / kBlock);
  return basis;
}

/// The largest coefficient of an orthonormal DCT.
double largest_coefficient(const Block& block) {
  static const Basis basis = cosines();
  double largest = 0;
  for (const auto& down : basis)
    for (const auto& across : basis) {
      double sum = 0;
      for (std::size_t j = 0; j < kBlock; ++j)
        for (std::size_t i = 0; i < kBlock; ++i) sum += down[j] * across[i] * block[j * kBlock + i];
      largest = std::max(largest, std::abs(sum));
    }
  return largest;
}

struct Mean {
  double sum = 0, weight = 0;
  void add(const Block& slope) {
    double square = 0;
    for (const double s : slope) square += s * s;
    const double largest = largest_coefficient(slope);
    sum += square * largest;
    weight += square;
  }
  double unnoticed() const { return sum > 0 ? weight / sum : 0; }
};

bool counts(const Circle& rim, int left, int top, double margin) {
  const double middle = 0.5 * (kBlock - 1);
  const double off = std::hypot(left + middle - rim.x, top + middle - rim.y) - rim.radius;
  return margin < 0 ? off < middle : std::abs(off) < middle + margin;
}

}  // namespace

Point unnoticed_motion(const Picture& picture, const Circle& rim, double margin) {
  Mean along_x, along_y;
  for (int top = 0; top + kBlock <= picture.height(); top += kBlock)
    for (int left = 0; left + kBlock <= picture.width(); left += kBlock) {
      if (!counts(rim, left, top, margin)) continue;
      Block x{}, y{};
      for (int j = 0; j < kBlock; ++j)
        for (int i = 0; i < kBlock; ++i) {
          const auto level = [&](int dx, int dy) {
            return static_cast<double>(picture.at(std::clamp(left + i + dx, 0, picture.width() - 1),
                                                  std::clamp(top + j + dy, 0, picture.height() - 1)));
          };
          const auto at = static_cast<std::size_t>(j * kBlock + i);
          x[at] = 0.5 * (level(1, 0) - level(-1, 0));
          y[at] = 0.5 * (level(0, 1) - level(0, -1));
        }
      along_x.add(x);
      along_y.add(y);
    }
  return {along_x.unnoticed(), along_y.unnoticed()};
}

}  // namespace tribotrack::vision
