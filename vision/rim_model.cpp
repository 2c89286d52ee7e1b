#include "vision/rim_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "vision/internal/vector_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kBlock = 64;            ///< pixels that are summed together
constexpr int kColumns = kRimParameters + 1;  ///< slopes, then the residual
constexpr int kSums = kColumns * (kColumns + 1) / 2;

/// Phi and phi at multiples of 1 / kPerUnit. Between them the Taylor series to the third order, whose
/// remainder is below (1 / (2 kPerUnit))^4 / 4! times the largest fourth derivative, 2e-11.
constexpr int kPerUnit = 128, kLimit = 8;
constexpr int kEntries = 2 * kLimit * kPerUnit + 1;

const std::array<NormalStep, kEntries>& table() {
  static const auto entries = [] {
    std::array<NormalStep, kEntries> out{};
    for (int k = 0; k < kEntries; ++k) {
      const double t = static_cast<double>(k) / kPerUnit - kLimit;
      out[static_cast<std::size_t>(k)] = {0.5 * std::erfc(-t / std::numbers::sqrt2),
                                          std::exp(-0.5 * t * t) / std::sqrt(2 * std::numbers::pi)};
    }
    return out;
  }();
  return entries;
}

TRIBOTRACK_KERNEL NormalStep step_from(const NormalStep* entries, double t) {
  if (!(t > -kLimit)) return {0, 0};
  if (t >= kLimit) return {1, 0};
  const int k = static_cast<int>((t + kLimit) * kPerUnit + 0.5);
  const double a = static_cast<double>(k) / kPerUnit - kLimit, d = t - a, aa = a * a;
  const NormalStep& e = entries[k];
  // phi^(n) = (-1)^n He_n phi, Hermite's polynomials.
  const double h2 = aa - 1, h3 = a * (aa - 3);
  return {e.value + e.density * d * (1 - d * (a * 0.5 - d * (h2 * (1.0 / 6) - d * h3 * (1.0 / 24)))),
          e.density * (1 - d * (a - d * (h2 * 0.5 - d * h3 * (1.0 / 6))))};
}

/// What of the parameters all pixels share.
struct RimConstants {
  double x, y, edge, inverse_s, inverse_r, r_slope;
  std::array<double, 6> in;
  std::array<double, 4> out;

  explicit RimConstants(const RimParameters& p)
      : x(p(0)),
        y(p(1)),
        edge(p(2) - p(3) * p(3) / (2 * p(2))),
        inverse_s(1 / p(3)),
        inverse_r(1 / p(2)),
        r_slope(1 / p(3) + p(3) / (2 * p(2) * p(2))) {
    for (int k = 0; k < 6; ++k) in[static_cast<std::size_t>(k)] = p(kRimInside + k);
    for (int k = 0; k < 4; ++k) out[static_cast<std::size_t>(k)] = p(kRimOutside + k);
  }
};

/// The model; its slopes go to slope[0], slope[stride] ...
TRIBOTRACK_KERNEL double model_at(const RimConstants& c, const NormalStep* entries, double px, double py,
                                  bool slopes, double* slope, std::size_t stride) {
  const double dx = px - c.x, dy = py - c.y;
  const double rho = std::sqrt(std::max(1e-18, dx * dx + dy * dy));
  const double t = (c.edge - rho) * c.inverse_s;
  const NormalStep step = step_from(entries, t);
  const double u = dx * c.inverse_r, v = dy * c.inverse_r;
  const double uu = u * u, uv = u * v, vv = v * v;
  const double level_in = c.in[0] + c.in[1] * u + c.in[2] * v + c.in[3] * uu + c.in[4] * uv + c.in[5] * vv;
  const double level_out = c.out[0] + c.out[1] * u + c.out[2] * v + c.out[3] * (uu + vv);
  if (slopes) {
    const double rise = (level_in - level_out) * step.density;
    const double along = rise * c.inverse_s / rho, outside = 1 - step.value;
    slope[0 * stride] = along * dx;
    slope[1 * stride] = along * dy;
    slope[2 * stride] = rise * c.r_slope;
    slope[3 * stride] = -rise * (t * c.inverse_s + c.inverse_r);
    slope[4 * stride] = step.value;
    slope[5 * stride] = step.value * u;
    slope[6 * stride] = step.value * v;
    slope[7 * stride] = step.value * uu;
    slope[8 * stride] = step.value * uv;
    slope[9 * stride] = step.value * vv;
    slope[10 * stride] = outside;
    slope[11 * stride] = outside * u;
    slope[12 * stride] = outside * v;
    slope[13 * stride] = outside * (uu + vv);
  }
  return level_out + (level_in - level_out) * step.value;
}

using Lanes = VectorOf<double, 4>::type;

using Sums = std::array<double, kSums>;

TRIBOTRACK_KERNEL void add_block(const double (&column)[kColumns][kBlock], const double (&weight)[kBlock],
                                 Sums& sums) {
  double weighted[kBlock];
  for (int i = 0, at = 0; i < kColumns; ++i) {
    for (std::size_t k = 0; k < kBlock; ++k) weighted[k] = weight[k] * column[i][k];
    for (int j = 0; j <= i; ++j, ++at) {
      Lanes even{}, odd{};
      for (std::size_t k = 0; k < kBlock; k += 8) {
        Lanes a, b, c, d;
        load(weighted + k, a);
        load(column[j] + k, b);
        load(weighted + k + 4, c);
        load(column[j] + k + 4, d);
        even += a * b;
        odd += c * d;
      }
      const Lanes both = even + odd;
      sums[static_cast<std::size_t>(at)] += (both[0] + both[1]) + (both[2] + both[3]);
    }
  }
}

TRIBOTRACK_KERNEL void sums_of(const RimConstants& c, const NormalStep* entries, const RimPixels& pixels,
                               Sums& sums) {
  double column[kColumns][kBlock] = {}, weight[kBlock] = {};
  const std::size_t count = pixels.x.size();
  std::size_t filled = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!(pixels.weight[i] > 0)) continue;
    column[kRimParameters][filled] = pixels.level[i] - model_at(c, entries, pixels.x[i], pixels.y[i], true,
                                                                &column[0][0] + filled, kBlock);
    weight[filled] = pixels.weight[i];
    if (++filled < kBlock) continue;
    add_block(column, weight, sums);
    filled = 0;
  }
  for (std::size_t k = filled; k < kBlock; ++k) weight[k] = 0;
  if (filled > 0) add_block(column, weight, sums);
}

TRIBOTRACK_KERNEL void residuals_of(const RimConstants& c, const NormalStep* entries, const RimPixels& pixels,
                                    double* out) {
  for (std::size_t i = 0; i < pixels.x.size(); ++i)
    out[i] = pixels.level[i] - model_at(c, entries, pixels.x[i], pixels.y[i], false, nullptr, 0);
}

// The same functions for each instruction set.
struct Kernels {
  void (*sums)(const RimConstants&, const NormalStep*, const RimPixels&, Sums&);
  void (*residuals)(const RimConstants&, const NormalStep*, const RimPixels&, double*);
};

#define TRIBOTRACK_VARIANT(suffix, ...)                                                               \
  __VA_ARGS__ void sums_##suffix(const RimConstants& c, const NormalStep* e, const RimPixels& p,      \
                                 Sums& out) {                                                         \
    sums_of(c, e, p, out);                                                                            \
  }                                                                                                   \
  __VA_ARGS__ void residuals_##suffix(const RimConstants& c, const NormalStep* e, const RimPixels& p, \
                                      double* out) {                                                  \
    residuals_of(c, e, p, out);                                                                       \
  }                                                                                                   \
  constexpr Kernels k_##suffix{sums_##suffix, residuals_##suffix};

TRIBOTRACK_VARIANT(baseline)
TRIBOTRACK_VARIANT(avx2, TRIBOTRACK_AVX2)
#undef TRIBOTRACK_VARIANT

const Kernels& kernels() {
  static const Kernels& fastest = runs_avx2() ? k_avx2 : k_baseline;
  return fastest;
}

}  // namespace

NormalStep normal_step(double t) {
  return step_from(table().data(), t);
}

double rim_model(const RimParameters& p, double x, double y, RimParameters& slope) {
  return model_at(RimConstants(p), table().data(), x, y, true, slope.data(), 1);
}

RimSums rim_sums(const RimParameters& p, const RimPixels& pixels) {
  Sums sums{};
  kernels().sums(RimConstants(p), table().data(), pixels, sums);
  RimSums out;
  std::size_t at = 0;
  for (int i = 0; i < kRimParameters; ++i)
    for (int j = 0; j <= i; ++j) out.normal(i, j) = out.normal(j, i) = sums[at++];
  for (int j = 0; j < kRimParameters; ++j) out.gradient(j) = sums[at++];
  out.cost = sums[at];
  return out;
}

std::vector<double> rim_residuals(const RimParameters& p, const RimPixels& pixels) {
  std::vector<double> out(pixels.x.size());
  kernels().residuals(RimConstants(p), table().data(), pixels, out.data());
  return out;
}

std::vector<double> rim_pulls(const RimParameters& p, const RimPixels& pixels, const RimParameters& row) {
  const RimConstants c(p);
  const NormalStep* entries = table().data();
  std::vector<double> out(pixels.x.size());
  RimParameters slope;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double r = pixels.level[i] - model_at(c, entries, pixels.x[i], pixels.y[i], true, slope.data(), 1);
    out[i] = pixels.weight[i] * r * row.dot(slope);
  }
  return out;
}

}  // namespace tribotrack::vision
