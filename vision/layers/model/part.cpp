#include "vision/layers/model/model.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "vision/kernels/parallel.h"
#include "vision/kernels/plane.h"
#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr double kTrim = 5;  ///< sd: further off is something else
/// Sd of alpha along a ring about the blurred rim: a shadow takes a tenth or two.
constexpr double kShadow = 0.2;
/// And of a place about what its ring says: an even shadow has none, a place's own estimate scatters by more.
constexpr double kPriorShare = 0.05;
/// Of the ground's mean level: what the model of the light may leave, alike in all windows and all around.
constexpr double kUnevenLight = 0.002;
constexpr float kInside = 1e-3F;    ///< share of the ground: less is inside the rim's blur
constexpr double kOpaque = 1e-3;    ///< sd of alpha there
constexpr double kMostShare = 1.1;  ///< a chamfer lights the ground beside it up by no more
constexpr double kBlendEvidence =
    100;                          ///< px^-4: sd of kappa 0.1 px^2 about that of a pixel, as lenses have it
constexpr double kMostBlend = 9;  ///< px^2
constexpr float kFewest = 4;      ///< windows at a place, of which two unknowns take two

/// By a Gaussian of 1 px.
Picture smoothed(const Picture& picture) {
  Picture out = picture;
  cv::GaussianBlur(matrix_of(picture), matrix_of(out), {5, 5}, 1, 1, cv::BORDER_REPLICATE);
  return out;
}

/// What is summed at a place over windows: of 1, the interpolation's share of white noise and, weighted, a^2,
/// a h, h^2, a y, h y, y^2; of q r and q^2 over the variance of r.
enum Sum { kCount, kPassed, kAA, kAH, kHH, kAY, kHY, kYY, kQR, kQQ, kSums };
using SumPictures = std::array<Picture, kSums>;

/// A row of a window's places on the part's grid.
struct WindowRow {
  const float *level, *below, *below_x, *below_y, *unsure;   ///< I, G - mean G and its slopes, var G
  const float *part, *share, *share_x, *share_y, *variance;  ///< of before
  float u, v;                                                ///< of the first place
  float gain, slope_x, slope_y, under, mean;                 ///< a, a s, b, mean G
  float counts;                                              ///< 1: a number, or the loop would branch
  float passed, trim, blend;                                 ///< of white noise, squared sd, kappa
  int count;
};

TRIBOTRACK_CLONES
void add_row(const WindowRow& row, const std::array<float*, kSums>& sums) {
  const WindowRow w = row;  // what the loop writes does not change these
  float *count = sums[kCount], *passed = sums[kPassed], *aa = sums[kAA], *ah = sums[kAH], *hh = sums[kHH],
        *ay = sums[kAY], *hy = sums[kHY], *yy = sums[kYY], *qr = sums[kQR], *qq = sums[kQQ];
#pragma GCC ivdep
  for (int i = 0; i < w.count; ++i) {
    const float a = w.gain + w.slope_x * (w.u + static_cast<float>(i)) + w.slope_y * w.v;
    const float h = w.under * (w.below[i] + w.mean) - a * w.mean;
    const float q = w.under * (w.share_x[i] * w.below_x[i] + w.share_y[i] * w.below_y[i]);
    const float y = w.level[i] - a * w.part[i] - w.blend * q, r = y - w.share[i] * h;
    const float seen = w.share[i] * w.under, sd2 = w.variance[i] + seen * seen * w.unsure[i];
    const float ok = r * r > w.trim * sd2 ? 0.0F : w.counts;
    const float once = ok / sd2;
    const float weight = once * w.variance[i], weight_a = weight * a, weight_h = weight * h;
    count[i] += ok;
    passed[i] += ok * w.passed;
    aa[i] += weight_a * a;
    ah[i] += weight_a * h;
    hh[i] += weight_h * h;
    ay[i] += weight_a * y;
    hy[i] += weight_h * y;
    yy[i] += weight * y * y;
    qr[i] += once * q * r;
    qq[i] += once * q * q;
  }
}

/// Sums over windows, by bands of rows each of which sees all windows: they do not depend on the threads.
SumPictures sums_over(WindowSpan windows, const PartPictures& before, const GroundPicture& ground,
                      double trim, int threads) {
  constexpr int kBand = 32;
  const int size = 2 * before.half + 1;
  SumPictures sums;
  sums.fill(Picture(size, size));
  Picture share(size, size), share_x(size, size), share_y(size, size);
  QuinticSpline(before.share)
      .sample_window(0, 0, size, size, share.levels().data(), share_x.levels().data(),
                     share_y.levels().data());
  const auto add = [&](const KeptWindow& window, int first_row, int end_row) {
    thread_local std::vector<float> level, below, below_x, below_y, unsure;
    const LayeredState& s = window.state;
    const double left = s.centre.x - before.half - window.x, top = s.centre.y - before.half - window.y;
    const int x = static_cast<int>(std::floor(left)), y = static_cast<int>(std::floor(top));
    // Between the first and the last pixel of the window.
    const int i0 = std::max(0, -x), i1 = std::min(size, window.picture.width() - 1 - x);
    const int j0 = std::max(first_row, -y), j1 = std::min(end_row, window.picture.height() - 1 - y);
    if (i1 <= i0 || j1 <= j0) return;
    const auto places = static_cast<std::size_t>(i1 - i0) * static_cast<std::size_t>(j1 - j0);
    for (auto* of : {&level, &below, &below_x, &below_y, &unsure}) of->resize(places);
    window.spline.sample_window(left + i0, top + j0, i1 - i0, j1 - j0, level.data(), nullptr, nullptr);
    ground.sample(s.centre.x - before.half - s.ground.x + i0, s.centre.y - before.half - s.ground.y + j0,
                  i1 - i0, j1 - j0, below.data(), unsure.data(), below_x.data(), below_y.data());
    const double passed = quintic_noise(left).value * quintic_noise(top).value;
    for (int j = j0; j < j1; ++j) {
      const std::size_t at = static_cast<std::size_t>(j - j0) * static_cast<std::size_t>(i1 - i0);
      const auto row = [&](const Picture& of) { return of.row(j).data() + i0; };
      std::array<float*, kSums> to{};
      for (std::size_t k = 0; k < kSums; ++k) to[k] = sums[k].row(j).data() + i0;
      add_row({level.data() + at,
               below.data() + at,
               below_x.data() + at,
               below_y.data() + at,
               unsure.data() + at,
               row(before.level),
               row(before.share),
               row(share_x),
               row(share_y),
               row(before.variance),
               static_cast<float>(i0 - before.half),
               static_cast<float>(j - before.half),
               static_cast<float>(s.gain),
               static_cast<float>(s.gain * s.slope_x),
               static_cast<float>(s.gain * s.slope_y),
               static_cast<float>(s.ground_gain),
               static_cast<float>(ground.mean()),
               1.0F,
               static_cast<float>(passed),
               static_cast<float>(trim * trim),
               static_cast<float>(before.blend),
               i1 - i0},
              to);
    }
  };
  parallel_for(static_cast<std::size_t>((size + kBand - 1) / kBand), threads,
               [&](std::size_t band, std::size_t) {
                 const int first = static_cast<int>(band) * kBand;
                 for (const KeptWindow* window : windows) add(*window, first, std::min(size, first + kBand));
               });
  return sums;
}

using Waves = Eigen::Matrix<double, 5, 1>;

/// Calls act(place, ring below, share of the ring above, 1, cos phi, sin phi, cos 2 phi, sin 2 phi).
void for_each_place(int size, const auto& act) {
  for (int j = 0, at = 0; j < size; ++j)
    for (int i = 0; i < size; ++i, ++at) {
      const double u = i - size / 2, v = j - size / 2, rho = std::hypot(u, v), phi = std::atan2(v, u);
      const Waves waves{1, std::cos(phi), std::sin(phi), std::cos(2 * phi), std::sin(2 * phi)};
      act(static_cast<std::size_t>(at), static_cast<std::size_t>(rho), rho - std::floor(rho), waves);
    }
}

/// alpha as what each place says of it, F being free, is smooth along the rings about the centre, a pixel
/// wide and linear between: the blurred rim is, and a shadow. Waves are 0 but for chance beforehand, so that
/// rings of which little is known stay flat.
Picture share_of_rings(const SumPictures& sums, double mean_ground, double noise_variance,
                       const Picture& prior_share) {
  struct Ring {
    Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
    Waves right = Waves::Zero();
    double windows = 0;
  };
  std::vector<Ring> rings(static_cast<std::size_t>(prior_share.width()) + 2);
  for_each_place(
      prior_share.width(), [&](std::size_t i, std::size_t below, double above, const Waves& waves) {
        const auto at = [&](Sum sum) { return static_cast<double>(sums[sum].levels()[i]); };
        const double prior = prior_share.levels()[i], aa = at(kAA), ah = at(kAH);
        const double information = at(kHH) - ah * ah / aa;
        const bool tells = !(at(kCount) < kFewest) && prior >= kInside && information > 0;
        const double off = tells ? (at(kHY) - ah * at(kAY) / aa) / information - prior : 0;
        for (const auto& [ring, share] : {std::pair{below, 1 - above}, std::pair{below + 1, above}}) {
          rings[ring].windows += share * at(kCount);
          if (!tells) continue;
          const double weight = share * information / noise_variance;
          rings[ring].normal += weight * waves * waves.transpose();
          rings[ring].right += weight * off * waves;
        }
      });
  // A ring's places lean on the same light: no number of them averages out what its model leaves.
  const double most = noise_variance / std::pow(kUnevenLight * mean_ground, 2);
  std::vector<Waves> fitted;
  for (const Ring& ring : rings) {
    const double share = std::min(1.0, most / std::max(ring.windows, 1e-9));
    const Eigen::Matrix<double, 5, 5> normal =
        share * ring.normal + Eigen::Matrix<double, 5, 5>::Identity() / (kShadow * kShadow);
    fitted.push_back(normal.ldlt().solve(share * ring.right));
  }
  Picture out = prior_share;
  for_each_place(out.width(), [&](std::size_t i, std::size_t below, double above, const Waves& waves) {
    out.levels()[i] +=
        static_cast<float>(((1 - above) * fitted[below] + above * fitted[below + 1]).dot(waves));
  });
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
  const SumPictures sums =
      sums_over(windows, before, ground, trim ? kTrim : std::numeric_limits<double>::infinity(), threads);
  const auto at = [&](Sum sum, std::size_t i) { return static_cast<double>(sums[sum].levels()[i]); };
  const Picture smooth_share = share_of_rings(sums, ground.mean(), noise_variance, prior_share);
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
    const double held = hh + prior, pulled = hy + prior * smooth_share.levels()[i];
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

IlluminationSlope::IlluminationSlope(std::span<const MeasuredSlope> slopes) {
  const auto n = static_cast<double>(slopes.size());
  if (slopes.size() < 4) throw std::invalid_argument("IlluminationSlope: fewer than four slopes");
  for (const MeasuredSlope& s : slopes) {
    middle_.x += s.place.x / n;
    middle_.y += s.place.y / n;
    noise_ += s.variance / n;
  }
  constexpr double kNoSpread = 0.5;  ///< px: places that differ by less tell nothing of S
  Eigen::Matrix3d normal = n * Eigen::Vector3d(0, kNoSpread * kNoSpread, kNoSpread * kNoSpread).asDiagonal();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (const MeasuredSlope& s : slopes) {
    const Eigen::Vector3d t = terms(s.place);
    normal += t * t.transpose();
    right += t * Eigen::RowVector2d(s.slope_x, s.slope_y);
  }
  inverse_ = normal.inverse();
  field_ = inverse_ * right;
  double square = 0, even = 0;
  for (const MeasuredSlope& s : slopes) even += s.slope_x * s.slope_x + s.slope_y * s.slope_y;
  for (const MeasuredSlope& s : slopes)
    square += (Eigen::Vector2d(s.slope_x, s.slope_y) - field_.transpose() * terms(s.place)).squaredNorm();
  constexpr double kUnknownScatter = 0.1;  ///< of the noise's variance: a scatter below goes unnoticed
  constexpr double kNoChance = 5;          ///< of Fisher's ratio: once in 4000 fields of forty slopes
  // Fisher's ratio: what each of the field's six numbers explains over what is left of each degree of
  // freedom.
  known_ = (even - square) / 6 > kNoChance * square / (2 * (n - 3));
  scatter_ = std::max(0.0, square / (2 * (n - 3)) - noise_) + kUnknownScatter * noise_;
}

LightPrior IlluminationSlope::at(const Point& place) const {
  if (!known_) return {};
  const Eigen::Vector3d t = terms(place);
  const Eigen::Vector2d g = field_.transpose() * t;
  return {g.x(), g.y(), std::sqrt(scatter_ + noise_ * t.dot(inverse_ * t))};
}

}  // namespace tribotrack::vision
