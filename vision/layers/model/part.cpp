#include "vision/layers/model/part.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "vision/layers/model/part_sums.h"
#include "vision/layers/model/ring_fit.h"

namespace tribotrack::vision {
namespace {

constexpr double kTrim = 5;  ///< sd: further off is something else
/// Sd of alpha along a ring about the blurred rim: a shadow takes a tenth or two.
constexpr double kShadow = 0.2;
/// And of a place about what its ring says: an even shadow has none, a place's own estimate scatters by more.
constexpr double kPriorShare = 0.05;
constexpr float kInside = 1e-3F;    ///< share of the ground: less is inside the rim's blur
constexpr double kOpaque = 1e-3;    ///< sd of alpha there
constexpr double kMostShare = 1.1;  ///< a chamfer lights the ground beside it up by no more
constexpr double kBlendEvidence =
    100;                          ///< px^-4: sd of kappa 0.1 px^2 about that of a pixel, as lenses have it
constexpr double kMostBlend = 9;  ///< px^2
constexpr float kFewest = 4;      ///< windows at a place, of which two unknowns take two
/// Of the ground's mean level: what the model of the light may leave, alike in all windows and all around.
constexpr double kUnevenLight = 0.002;

/// (1 2 1) / 4 both ways, twice: a Gaussian of 1 px.
Picture smoothed(Picture picture) {
  const int w = picture.width(), h = picture.height();
  for (int pass = 0; pass < 2; ++pass) {
    Picture rows(w, h);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        rows.at(x, y) = 0.25F * (picture.at(std::max(0, x - 1), y) + 2 * picture.at(x, y) +
                                 picture.at(std::min(w - 1, x + 1), y));
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        picture.at(x, y) =
            0.25F * (rows.at(x, std::max(0, y - 1)) + 2 * rows.at(x, y) + rows.at(x, std::min(h - 1, y + 1)));
  }
  return picture;
}

/// The sums as pictures on the part's grid.
struct SumPictures {
  Picture count, passed, aa, ah, hh, ay, hy, yy, qr, qq;
  explicit SumPictures(const PartTileSums& sums)
      : count(sums.picture(kCount)),
        passed(sums.picture(kPassed)),
        aa(sums.picture(kAA)),
        ah(sums.picture(kAH)),
        hh(sums.picture(kHH)),
        ay(sums.picture(kAY)),
        hy(sums.picture(kHY)),
        yy(sums.picture(kYY)),
        qr(sums.picture(kQR)),
        qq(sums.picture(kQQ)) {}
};

/// alpha as the rings have it: what each place says of it, F being free, smoothed along them.
Picture share_of_rings(const SumPictures& sums, const GroundPicture& ground, double noise_variance,
                       const Picture& prior_share) {
  Picture off(prior_share.width(), prior_share.height()), weight = off;
  for (std::size_t i = 0; i < sums.count.levels().size(); ++i) {
    if (sums.count.levels()[i] < kFewest || prior_share.levels()[i] < kInside) continue;
    const double aa = sums.aa.levels()[i], ah = sums.ah.levels()[i];
    const double information = sums.hh.levels()[i] - ah * ah / aa;
    if (!(information > 0)) continue;
    const double share = (sums.hy.levels()[i] - ah * sums.ay.levels()[i] / aa) / information;
    off.levels()[i] = static_cast<float>(share) - prior_share.levels()[i];
    weight.levels()[i] = static_cast<float>(information / noise_variance);
  }
  // A ring's places lean on the same light: no number of them averages out what its model leaves.
  const RingLimit limit{sums.count, noise_variance / std::pow(kUnevenLight * ground.mean(), 2)};
  Picture out = ring_fit(off, weight, kShadow, &limit);
  for (std::size_t i = 0; i < out.levels().size(); ++i) out.levels()[i] += prior_share.levels()[i];
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

PartRegression::PartRegression(const PartPictures& before, const GroundPicture& ground)
    : before_(before), ground_(ground), sums_(std::make_unique<PartTileSums>(before, ground)) {}

PartRegression::~PartRegression() = default;

void PartRegression::add(WindowSpan windows, bool trim, int threads) {
  sums_->add(windows, trim ? kTrim : std::numeric_limits<double>::infinity(), threads);
}

PartPictures PartRegression::solve(double noise_variance, const Picture& prior_share) const {
  PartPictures out = before_;
  const SumPictures sums(*sums_);
  const Picture smooth_share = share_of_rings(sums, ground_, noise_variance, prior_share);
  double widest = noise_variance;
  std::vector<std::size_t> unseen;
  for (std::size_t i = 0; i < sums.count.levels().size(); ++i) {
    const double n = sums.count.levels()[i];
    if (n < static_cast<double>(kFewest)) {
      unseen.push_back(i);
      continue;
    }
    // [aa ah; ah hh + prior] [F - F of before; alpha] = [ay; hy + prior alpha_0]
    const double aa = sums.aa.levels()[i], ah = sums.ah.levels()[i], hh = sums.hh.levels()[i];
    const double ay = sums.ay.levels()[i], hy = sums.hy.levels()[i], yy = sums.yy.levels()[i];
    const double prior =
        noise_variance / std::pow(prior_share.levels()[i] < kInside ? kOpaque : kPriorShare, 2);
    const double held = hh + prior, pulled = hy + prior * smooth_share.levels()[i];
    const double det = aa * held - ah * ah;
    const double level = (held * ay - ah * pulled) / det, share = (aa * pulled - ah * ay) / det;
    const double squares = yy - 2 * level * ay - 2 * share * hy + level * level * aa +
                           2 * level * share * ah + share * share * hh;
    // Interpolation passes only a part of the noise, and two unknowns have taken theirs.
    const double left = std::max(0.0, squares) / sums.passed.levels()[i] * n / (n - 2);
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
  double qr = 0, qq = 0;
  for (std::size_t i = 0; i < sums.qr.levels().size(); ++i) {
    qr += static_cast<double>(sums.qr.levels()[i]);
    qq += static_cast<double>(sums.qq.levels()[i]);
  }
  out.blend = std::clamp(before_.blend + qr / (qq + kBlendEvidence), 0.0, kMostBlend);
  return out;
}

namespace {

using Waves = Eigen::Matrix<double, 5, 1>;

struct Ring {
  Eigen::Matrix<double, 5, 5> normal;
  Waves right = Waves::Zero();
  double observations = 0;
};

/// Calls act(place, ring below, share of the ring above, waves) for every place of the grid.
template <class Act>
void for_each_place(int size, const Act& act) {
  const int half = size / 2;
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      const double rho = std::hypot(i - half, j - half), phi = std::atan2(j - half, i - half);
      const auto ring = static_cast<std::size_t>(rho);
      Waves waves;
      waves << 1, std::cos(phi), std::sin(phi), std::cos(2 * phi), std::sin(2 * phi);
      act(static_cast<std::size_t>(j) * static_cast<std::size_t>(size) + static_cast<std::size_t>(i), ring,
          rho - static_cast<double>(ring), waves);
    }
}

}  // namespace

Picture ring_fit(const Picture& values, const Picture& weights, double sd, const RingLimit* limit) {
  const int size = values.width();
  std::vector<Ring> rings(static_cast<std::size_t>(size) + 2);
  for (Ring& ring : rings) ring.normal.setZero();
  for_each_place(size, [&](std::size_t at, std::size_t below, double above, const Waves& waves) {
    const auto weight = static_cast<double>(weights.levels()[at]);
    const auto value = static_cast<double>(values.levels()[at]);
    for (const auto& [ring, share] : {std::pair{below, 1 - above}, std::pair{below + 1, above}}) {
      rings[ring].normal += share * weight * waves * waves.transpose();
      rings[ring].right += share * weight * value * waves;
      if (limit) rings[ring].observations += share * static_cast<double>(limit->observations.levels()[at]);
    }
  });
  std::vector<Waves> fitted;
  const Eigen::Matrix<double, 5, 5> prior = Eigen::Matrix<double, 5, 5>::Identity() / (sd * sd);
  for (const Ring& ring : rings) {
    const double share = limit && ring.observations > limit->most ? limit->most / ring.observations : 1;
    fitted.push_back((prior + share * ring.normal).ldlt().solve(share * ring.right));
  }
  Picture out(size, size);
  for_each_place(size, [&](std::size_t at, std::size_t below, double above, const Waves& waves) {
    out.levels()[at] =
        static_cast<float>(((1 - above) * fitted[below] + above * fitted[below + 1]).dot(waves));
  });
  return out;
}

}  // namespace tribotrack::vision
