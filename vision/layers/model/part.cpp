#include "vision/layers/model/part.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/kernels/vector_kernels.h"
#include "vision/layers/model/ring_fit.h"

namespace tribotrack::vision {
namespace {

constexpr double kTrim = 5;  ///< sd: further off is something else
/// Sd of alpha along a ring about the blurred rim: a shadow takes a tenth or two.
constexpr double kShadow = 0.2;
/// And of a place about what its ring says: an even shadow has none, a place's own estimate scatters by more.
constexpr double kPriorShare = 0.05;
constexpr float kInside = 1e-3F;  ///< share of the ground: less is inside the rim's blur
constexpr double kOpaque = 1e-3;  ///< sd of alpha there
constexpr double kBlendEvidence =
    100;                          ///< px^-4: sd of kappa 0.1 px^2 about that of a pixel, as lenses have it
constexpr double kMostBlend = 9;  ///< px^2
constexpr float kFewest = 4;      ///< windows at a place, of which two unknowns take two

/// One row of a window on the part's grid.
struct RowOfWindow {
  const float *level, *below, *below_x, *below_y;  ///< I, b (G - mean G) and its slopes
  const float *share_x, *share_y, *unsure;         ///< grad alpha, b^2 var G
  const float *part, *share, *variance;            ///< of before
  const float* turned;                             ///< null where nothing turns
  float gain, side, slope, mean, darker;           ///< a, a s_y v, a s_x, mean G, (b - a) mean G
  float passed, trim, blend;                       ///< of white noise, squared sd, kappa
  int first;                                       ///< u of the first place
  int count;
};

struct RowOfSums {
  float *count, *passed, *aa, *ag, *gg, *ay, *gy, *yy, *qr, *qq;
};

TRIBOTRACK_CLONES
void add_row(const RowOfWindow& w, const RowOfSums& s) {
  const bool turns = w.turned != nullptr;
  for (int i = 0; i < w.count; ++i) {
    const float a = w.gain, lit = w.side + w.slope * static_cast<float>(w.first + i), g = w.below[i];
    const float part = turns ? w.part[i] + w.turned[i] : w.part[i];
    const float q = w.share_x[i] * w.below_x[i] + w.share_y[i] * w.below_y[i];
    const float y = w.level[i] - a * part - lit * (part - w.mean * w.share[i]) - w.darker * w.share[i] -
                    w.blend * q,
                r = y - w.share[i] * g;
    const float sd2 = w.variance[i] + w.share[i] * w.share[i] * w.unsure[i];
    const float ok = r * r > w.trim * sd2 ? 0.0F : 1.0F, weight = ok * w.variance[i] / sd2;
    s.count[i] += ok;
    s.passed[i] += ok * w.passed;
    s.aa[i] += weight * a * a;
    s.ag[i] += weight * a * g;
    s.gg[i] += weight * g * g;
    s.ay[i] += weight * a * y;
    s.gy[i] += weight * g * y;
    s.yy[i] += weight * y * y;
    s.qr[i] += ok * q * r / sd2;
    s.qq[i] += ok * q * q / sd2;
  }
}

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
    : before_(before), ground_(ground) {
  const int size = 2 * before.half + 1;
  Picture value(size, size);
  share_x_ = share_y_ = value;
  QuinticSpline(before.share)
      .sample_window(0, 0, size, size, value.levels().data(), share_x_.levels().data(),
                     share_y_.levels().data());
  for (Picture* p : {&count_, &passed_, &aa_, &ag_, &gg_, &ay_, &gy_, &yy_, &qr_, &qq_, &level_, &below_,
                     &below_x_, &below_y_, &unsure_here_})
    *p = Picture(size, size);
}

void PartRegression::add(const KeptWindow& window, bool trim, const Picture* turned) {
  const LayeredState& s = window.state;
  const int half = before_.half, size = 2 * half + 1;
  // Places of the grid inside the window.
  const double left = s.centre.x - half - window.x, top = s.centre.y - half - window.y;
  const int i0 = std::max(0, static_cast<int>(std::ceil(-left))),
            j0 = std::max(0, static_cast<int>(std::ceil(-top)));
  const int i1 = std::min(size - 1, static_cast<int>(std::floor(window.picture.width() - 1 - left))),
            j1 = std::min(size - 1, static_cast<int>(std::floor(window.picture.height() - 1 - top)));
  if (i1 < i0 || j1 < j0) return;
  const int width = i1 - i0 + 1, height = j1 - j0 + 1;
  window.spline.sample_window(left + i0, top + j0, width, height, level_.levels().data(), nullptr, nullptr);
  ground_.sample(s.centre.x - half + i0 - s.ground.x, s.centre.y - half + j0 - s.ground.y, width, height,
                 below_.levels().data(), unsure_here_.levels().data(), below_x_.levels().data(),
                 below_y_.levels().data());
  const auto under = static_cast<float>(s.ground_gain);
  for (int k = 0; k < width * height; ++k) {
    below_.levels()[static_cast<std::size_t>(k)] *= under;
    below_x_.levels()[static_cast<std::size_t>(k)] *= under;
    below_y_.levels()[static_cast<std::size_t>(k)] *= under;
    unsure_here_.levels()[static_cast<std::size_t>(k)] *= under * under;
  }
  const auto noise = static_cast<float>(quintic_noise(left - std::floor(left)).value *
                                        quintic_noise(top - std::floor(top)).value);
  for (int j = 0; j < height; ++j) {
    const auto at =
        static_cast<std::size_t>(j0 + j) * static_cast<std::size_t>(size) + static_cast<std::size_t>(i0);
    const auto here = static_cast<std::size_t>(j) * static_cast<std::size_t>(width);
    const double v = j0 + j - half;
    const RowOfWindow row{level_.levels().data() + here,
                          below_.levels().data() + here,
                          below_x_.levels().data() + here,
                          below_y_.levels().data() + here,
                          share_x_.levels().data() + at,
                          share_y_.levels().data() + at,
                          unsure_here_.levels().data() + here,
                          before_.level.levels().data() + at,
                          before_.share.levels().data() + at,
                          before_.variance.levels().data() + at,
                          turned ? turned->levels().data() + at : nullptr,
                          static_cast<float>(s.gain),
                          static_cast<float>(s.gain * s.slope_y * v),
                          static_cast<float>(s.gain * s.slope_x),
                          static_cast<float>(ground_.mean()),
                          static_cast<float>((s.ground_gain - s.gain) * ground_.mean()),
                          noise,
                          trim ? static_cast<float>(kTrim * kTrim) : 1e30F,
                          static_cast<float>(before_.blend),
                          i0 - half,
                          width};
    add_row(row, {count_.levels().data() + at, passed_.levels().data() + at, aa_.levels().data() + at,
                  ag_.levels().data() + at, gg_.levels().data() + at, ay_.levels().data() + at,
                  gy_.levels().data() + at, yy_.levels().data() + at, qr_.levels().data() + at,
                  qq_.levels().data() + at});
  }
}

/// alpha as the rings have it: what each place says of it, F being free, smoothed along them.
Picture PartRegression::share_of_rings(double noise_variance, const Picture& prior_share, bool opaque) const {
  Picture off(prior_share.width(), prior_share.height()), weight = off;
  for (std::size_t i = 0; i < count_.levels().size(); ++i) {
    if (count_.levels()[i] < kFewest || (opaque && prior_share.levels()[i] < kInside)) continue;
    const double aa = aa_.levels()[i], ag = ag_.levels()[i];
    const double information = gg_.levels()[i] - ag * ag / aa;
    if (!(information > 0)) continue;
    const double share = (gy_.levels()[i] - ag * ay_.levels()[i] / aa) / information;
    off.levels()[i] = static_cast<float>(share) - prior_share.levels()[i];
    weight.levels()[i] = static_cast<float>(information / noise_variance);
  }
  Picture out = ring_fit(off, weight, kShadow);
  for (std::size_t i = 0; i < out.levels().size(); ++i) out.levels()[i] += prior_share.levels()[i];
  return out;
}

PartPictures PartRegression::solve(double noise_variance, const Picture& prior_share, bool opaque) const {
  PartPictures out = before_;
  const Picture smooth_share = share_of_rings(noise_variance, prior_share, opaque);
  double widest = noise_variance;
  std::vector<std::size_t> unseen;
  for (std::size_t i = 0; i < count_.levels().size(); ++i) {
    const double n = count_.levels()[i];
    if (n < static_cast<double>(kFewest)) {
      unseen.push_back(i);
      continue;
    }
    // [aa ag; ag gg + prior] [F - F of before; alpha] = [ay; gy + prior alpha_0]
    const double aa = aa_.levels()[i], ag = ag_.levels()[i], gg = gg_.levels()[i];
    const double ay = ay_.levels()[i], gy = gy_.levels()[i], yy = yy_.levels()[i];
    const double prior =
        noise_variance / std::pow(opaque && prior_share.levels()[i] < kInside ? kOpaque : kPriorShare, 2);
    const double held = gg + prior, pulled = gy + prior * smooth_share.levels()[i];
    const double det = aa * held - ag * ag;
    const double level = (held * ay - ag * pulled) / det, share = (aa * pulled - ag * ay) / det;
    const double squares = yy - 2 * level * ay - 2 * share * gy + level * level * aa +
                           2 * level * share * ag + share * share * gg;
    // Interpolation passes only a part of the noise, and two unknowns have taken theirs.
    const double left = std::max(0.0, squares) / passed_.levels()[i] * n / (n - 2);
    out.level.levels()[i] += static_cast<float>(level);
    out.share.levels()[i] = static_cast<float>(share);
    out.variance.levels()[i] = static_cast<float>(std::max(left, 1.0 / 12));
    widest = std::max(widest, left);
  }
  for (const std::size_t i : unseen) out.variance.levels()[i] = static_cast<float>(widest);
  // A quiet place beside a noisy one (a part that clips) must not lend it its weight.
  const Picture around = smoothed(out.variance);
  for (std::size_t i = 0; i < around.levels().size(); ++i)
    out.variance.levels()[i] = std::max(out.variance.levels()[i], around.levels()[i]);
  double qr = 0, qq = 0;
  for (std::size_t i = 0; i < qr_.levels().size(); ++i) {
    qr += static_cast<double>(qr_.levels()[i]);
    qq += static_cast<double>(qq_.levels()[i]);
  }
  out.blend = std::clamp(before_.blend + qr / (qq + kBlendEvidence), 0.0, kMostBlend);
  return out;
}

}  // namespace tribotrack::vision
