#include "vision/layers/model/part.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "vision/layers/model/part_sums.h"

namespace tribotrack::vision {
namespace {

constexpr double kTrim = 5;          ///< sd: further off is something else
constexpr double kPriorShare = 0.2;  ///< sd of alpha about the blurred rim: a shadow takes a tenth or two
constexpr float kInside = 1e-3F;     ///< share of the ground: less is inside the rim's blur
constexpr double kOpaque = 1e-3;     ///< sd of alpha there
constexpr double kMostShare = 1.1;   ///< a chamfer lights the ground beside it up by no more
constexpr double kBlendEvidence =
    100;                          ///< px^-4: sd of kappa 0.1 px^2 about that of a pixel, as lenses have it
constexpr double kMostBlend = 9;  ///< px^2
constexpr float kFewest = 4;      ///< windows at a place, of which two unknowns take two

/// By a Gaussian of 1 px.
Picture smoothed(const Picture& picture) {
  Picture out = picture;
  cv::Mat levels(out.height(), out.width(), CV_32F, out.levels().data());
  cv::GaussianBlur(levels, levels, {5, 5}, 1, 1, cv::BORDER_REPLICATE);
  return out;
}

}  // namespace

Picture blurred_rim(int half, double radius, double blur) {
  const int size = 2 * half + 1;
  Picture share(size, size);
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      const double t = (std::hypot(i - half, j - half) - radius) / blur;
      share.at(i, j) = static_cast<float>(0.5 * std::erfc(-t / std::numbers::sqrt2));
    }
  return share;
}

PartPictures learn_pictures(const PartPictures& before, const GroundPicture& ground, WindowSpan windows,
                            bool trim, double noise_variance, const Picture& prior_share, int threads) {
  PartTileSums tiles(before, ground);
  tiles.add(windows, trim ? kTrim : std::numeric_limits<double>::infinity(), threads);
  std::array<Picture, kPartSums> sums;
  for (int k = 0; k < kPartSums; ++k)
    sums[static_cast<std::size_t>(k)] = tiles.picture(static_cast<PartSum>(k));
  const auto at = [&](PartSum sum, std::size_t i) { return static_cast<double>(sums[sum].levels()[i]); };
  PartPictures out = before;
  double widest = noise_variance;
  std::vector<std::size_t> unseen;
  double qr = 0, qq = 0;
  for (std::size_t i = 0; i < out.level.levels().size(); ++i) {
    qr += at(kQR, i);
    qq += at(kQQ, i);
    const double n = at(kCount, i);
    if (n < static_cast<double>(kFewest)) {
      unseen.push_back(i);
      continue;
    }
    // [aa ah; ah hh + prior] [F - F of before; alpha] = [ay; hy + prior alpha_0]
    const double aa = at(kAA, i), ah = at(kAH, i), hh = at(kHH, i);
    const double ay = at(kAY, i), hy = at(kHY, i), yy = at(kYY, i);
    const double prior =
        noise_variance / std::pow(prior_share.levels()[i] < kInside ? kOpaque : kPriorShare, 2);
    const double held = hh + prior, pulled = hy + prior * prior_share.levels()[i];
    const double det = aa * held - ah * ah;
    const double level = (held * ay - ah * pulled) / det, share = (aa * pulled - ah * ay) / det;
    const double squares = yy - 2 * level * ay - 2 * share * hy + level * level * aa +
                           2 * level * share * ah + share * share * hh;
    // Interpolation passes only a part of the noise, and two unknowns have taken theirs.
    const double left = std::max(0.0, squares) / at(kPassed, i) * n / (n - 2);
    out.level.levels()[i] += static_cast<float>(level);
    out.share.levels()[i] = static_cast<float>(std::clamp(share, 0.0, kMostShare));
    out.variance.levels()[i] = static_cast<float>(std::max(left, 1.0 / 12));
    widest = std::max(widest, left);
  }
  for (const std::size_t i : unseen) out.variance.levels()[i] = static_cast<float>(widest);
  // A quiet place beside a noisy one (a part that clips) must not lend it its weight.
  const Picture around = smoothed(out.variance);
  for (std::size_t i = 0; i < around.levels().size(); ++i)
    out.variance.levels()[i] = std::max(out.variance.levels()[i], around.levels()[i]);
  out.blend = std::clamp(before.blend + qr / (qq + kBlendEvidence), 0.0, kMostBlend);
  return out;
}

}  // namespace tribotrack::vision
