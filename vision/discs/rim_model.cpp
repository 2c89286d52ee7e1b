#include "vision/discs/rim_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "vision/kernels/vector_kernels.h"

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

using Lanes = VectorOf<double, 4>::type;

/// A pixel, or four at once.
TRIBOTRACK_KERNEL double get(double number, std::size_t) {
  return number;
}
TRIBOTRACK_KERNEL double get(const Lanes& numbers, std::size_t k) {
  return numbers[k];
}
TRIBOTRACK_KERNEL void set(double& number, std::size_t, double to) {
  number = to;
}
TRIBOTRACK_KERNEL void set(Lanes& numbers, std::size_t k, double to) {
  numbers[k] = to;
}
template <class Number>
constexpr std::size_t kLanes = sizeof(Number) / sizeof(double);

template <class Number>
TRIBOTRACK_KERNEL void step_from(const NormalStep* entries, const Number& at, Number& value,
                                 Number& density) {
  Number t{}, a{}, entry{}, slope{};
  for (std::size_t k = 0; k < kLanes<Number>; ++k) {
    // The table's ends are 0 and 1 to the last digit but one.
    const double far = get(at, k), here = far > -kLimit ? far < kLimit ? far : kLimit : -kLimit;
    const int nearest = static_cast<int>((here + kLimit) * kPerUnit + 0.5);
    set(t, k, here);
    set(a, k, static_cast<double>(nearest) / kPerUnit - kLimit);
    set(entry, k, entries[nearest].value);
    set(slope, k, entries[nearest].density);
  }
  // phi^(n) = (-1)^n He_n phi, Hermite's polynomials.
  const Number d = t - a, aa = a * a, h2 = aa - 1, h3 = a * (aa - 3);
  value = entry + slope * d * (1 - d * (a * 0.5 - d * (h2 * (1.0 / 6) - d * h3 * (1.0 / 24))));
  density = slope * (1 - d * (a - d * (h2 * 0.5 - d * h3 * (1.0 / 6))));
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
template <class Number>
TRIBOTRACK_KERNEL void model_at(const RimConstants& c, const NormalStep* entries, const Number& px,
                                const Number& py, double* slope, std::size_t stride, Number& model) {
  const Number dx = px - c.x, dy = py - c.y;
  const Number square = dx * dx + dy * dy;
  Number rho{};
  for (std::size_t k = 0; k < kLanes<Number>; ++k) set(rho, k, std::sqrt(std::max(1e-18, get(square, k))));
  const Number t = (c.edge - rho) * c.inverse_s;
  Number value, density;
  step_from(entries, t, value, density);
  const Number u = dx * c.inverse_r, v = dy * c.inverse_r;
  const Number uu = u * u, uv = u * v, vv = v * v;
  const Number level_in = c.in[0] + c.in[1] * u + c.in[2] * v + c.in[3] * uu + c.in[4] * uv + c.in[5] * vv;
  const Number level_out = c.out[0] + c.out[1] * u + c.out[2] * v + c.out[3] * (uu + vv);
  model = level_out + (level_in - level_out) * value;
  if (!slope) return;
  const Number rise = (level_in - level_out) * density;
  const Number along = rise * c.inverse_s / rho, outside = 1 - value;
  const Number all[] = {
      along * dx,  along * dy,         rise * c.r_slope, -rise * (t * c.inverse_s + c.inverse_r),
      value,       value * u,          value * v,        value * uu,
      value * uv,  value * vv,         outside,          outside * u,
      outside * v, outside * (uu + vv)};
  for (std::size_t i = 0; i < kRimParameters; ++i) store(all[i], slope + i * stride);
}

using Sums = std::array<double, kSums>;

/// Four columns at a time, or as many as there are: each weighted number is loaded once for all of them.
template <int some>
TRIBOTRACK_KERNEL void add_products(const double (&weighted)[kBlock], const double (*column)[kBlock],
                                    double* sums) {
  Lanes even[some] = {}, odd[some] = {};
  for (std::size_t k = 0; k < kBlock; k += 8) {
    Lanes a, b;
    load(weighted + k, a);
    load(weighted + k + 4, b);
    for (int j = 0; j < some; ++j) {
      Lanes c, d;
      load(column[j] + k, c);
      load(column[j] + k + 4, d);
      even[j] += a * c;
      odd[j] += b * d;
    }
  }
  for (int j = 0; j < some; ++j) {
    const Lanes both = even[j] + odd[j];
    sums[j] += (both[0] + both[1]) + (both[2] + both[3]);
  }
}

TRIBOTRACK_KERNEL void add_block(const double (&column)[kColumns][kBlock], const double (&weight)[kBlock],
                                 Sums& sums) {
  double weighted[kBlock];
  double* to = sums.data();
  for (int i = 0; i < kColumns; ++i) {
    for (std::size_t k = 0; k < kBlock; ++k) weighted[k] = weight[k] * column[i][k];
    int j = 0;
    for (; j + 4 <= i + 1; j += 4) add_products<4>(weighted, column + j, to + j);
    for (; j <= i; ++j) add_products<1>(weighted, column + j, to + j);
    to += i + 1;
  }
}

/// Pixels that count, side by side.
struct Block {
  double x[kBlock], y[kBlock], level[kBlock], weight[kBlock];
};

TRIBOTRACK_KERNEL void add_pixels(const RimConstants& c, const NormalStep* entries, const Block& pixels,
                                  Sums& sums) {
  double column[kColumns][kBlock];
  for (std::size_t k = 0; k < kBlock; k += kLanes<Lanes>) {
    Lanes x, y, level, model;
    load(pixels.x + k, x);
    load(pixels.y + k, y);
    load(pixels.level + k, level);
    model_at(c, entries, x, y, &column[0][0] + k, kBlock, model);
    store(level - model, column[kRimParameters] + k);
  }
  add_block(column, pixels.weight, sums);
}

TRIBOTRACK_KERNEL void sums_of(const RimConstants& c, const NormalStep* entries, const RimPixels& pixels,
                               Sums& sums) {
  Block block{};
  const std::size_t count = pixels.x.size();
  std::size_t filled = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (pixels.weight[i] > 0) {
      block.x[filled] = pixels.x[i];
      block.y[filled] = pixels.y[i];
      block.level[filled] = pixels.level[i];
      block.weight[filled++] = pixels.weight[i];
    }
    if (filled < kBlock && i + 1 < count) continue;
    // What is left of the pixels before does not count.
    for (std::size_t k = filled; k < kBlock; ++k) block.weight[k] = 0;
    add_pixels(c, entries, block, sums);
    filled = 0;
  }
}

TRIBOTRACK_KERNEL void residuals_of(const RimConstants& c, const NormalStep* entries, const RimPixels& pixels,
                                    double* out) {
  const std::size_t count = pixels.x.size();
  std::size_t i = 0;
  for (; i + kLanes<Lanes> <= count; i += kLanes<Lanes>) {
    Lanes x, y, level, model;
    load(pixels.x.data() + i, x);
    load(pixels.y.data() + i, y);
    load(pixels.level.data() + i, level);
    model_at(c, entries, x, y, nullptr, 0, model);
    store(level - model, out + i);
  }
  for (; i < count; ++i) {
    double model;
    model_at(c, entries, pixels.x[i], pixels.y[i], nullptr, 0, model);
    out[i] = pixels.level[i] - model;
  }
}

TRIBOTRACK_KERNEL void pulls_of(const RimConstants& c, const NormalStep* entries, const RimPixels& pixels,
                                const double* row, double* out) {
  const std::size_t count = pixels.x.size();
  for (std::size_t i = 0; i < count; i += kLanes<Lanes>) {
    const std::size_t some = std::min(kLanes<Lanes>, count - i);
    double x[kLanes<Lanes>] = {}, y[kLanes<Lanes>] = {}, slope[kRimParameters][kLanes<Lanes>];
    std::copy_n(pixels.x.data() + i, some, x);
    std::copy_n(pixels.y.data() + i, some, y);
    Lanes at_x, at_y, model, along{};
    load(x, at_x);
    load(y, at_y);
    model_at(c, entries, at_x, at_y, &slope[0][0], kLanes<Lanes>, model);
    for (std::size_t j = 0; j < kRimParameters; ++j) {
      Lanes of;
      load(slope[j], of);
      along += row[j] * of;
    }
    for (std::size_t k = 0; k < some; ++k)
      out[i + k] = pixels.weight[i + k] * (pixels.level[i + k] - model[k]) * along[k];
  }
}

// The same functions for each instruction set.
struct Kernels {
  void (*sums)(const RimConstants&, const NormalStep*, const RimPixels&, Sums&);
  void (*residuals)(const RimConstants&, const NormalStep*, const RimPixels&, double*);
  void (*pulls)(const RimConstants&, const NormalStep*, const RimPixels&, const double*, double*);
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
  __VA_ARGS__ void pulls_##suffix(const RimConstants& c, const NormalStep* e, const RimPixels& p,     \
                                  const double* row, double* out) {                                   \
    pulls_of(c, e, p, row, out);                                                                      \
  }                                                                                                   \
  constexpr Kernels k_##suffix{sums_##suffix, residuals_##suffix, pulls_##suffix};

TRIBOTRACK_VARIANT(baseline)
TRIBOTRACK_VARIANT(avx2, TRIBOTRACK_AVX2)
#undef TRIBOTRACK_VARIANT

const Kernels& kernels() {
  static const Kernels& fastest = runs_avx2() ? k_avx2 : k_baseline;
  return fastest;
}

}  // namespace

NormalStep normal_step(double t) {
  NormalStep step;
  step_from(table().data(), t, step.value, step.density);
  return step;
}

double rim_model(const RimParameters& p, double x, double y, RimParameters& slope) {
  double model;
  model_at(RimConstants(p), table().data(), x, y, slope.data(), 1, model);
  return model;
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
  std::vector<double> out(pixels.x.size());
  kernels().pulls(RimConstants(p), table().data(), pixels, row.data(), out.data());
  return out;
}

}  // namespace tribotrack::vision
