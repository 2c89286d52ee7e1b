#include "vision/kernels/bspline.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>

#include "vision/kernels/plane.h"
#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr int kPanel = 32;  ///< signals filtered side by side

/// One sample of all signals of a panel, in vectors that fit registers: a recursion kept in memory waits for
/// it.
using Lanes = VectorOf<float, 8>::type;
constexpr int kVectors = kPanel / 8;

constexpr std::array<float, 2> kPoles = {-0.43057534709997379F, -0.04309628820326465F};
constexpr int kMemory = 28;  ///< |z|^28 < 1e-10

/// Samples to coefficients of kPanel signals at once, in place: panel[kPanel k + i] is sample k of signal i.
/// Unser, Aldroubi, Eden (1993), box 2, with whole-sample mirrors.
TRIBOTRACK_CLONES void prefilter_panel(float* panel, int n) {
  if (n < 2) return;
  const auto sample = [&](int k, int q) { return panel + static_cast<std::ptrdiff_t>(kPanel) * k + 8 * q; };
  for (const float z : kPoles) {
    const float gain = (1 - z) * (1 - 1 / z);
    Lanes sum[kVectors] = {};
    float power = 1;
    const int period = 2 * (n - 1);
    const int reach = std::min(period, kMemory);
    for (int k = 0; k < reach; ++k, power *= z)
      for (int q = 0; q < kVectors; ++q) {
        Lanes v;
        load(sample(k < n ? k : period - k, q), v);
        sum[q] += power * v;
      }
    Lanes before[kVectors];
    for (int q = 0; q < kVectors; ++q) {
      if (reach == period) sum[q] /= 1 - power;
      before[q] = gain * sum[q];
      store(before[q], sample(0, q));
    }
    for (int k = 1; k < n; ++k)
      for (int q = 0; q < kVectors; ++q) {
        Lanes v;
        load(sample(k, q), v);
        before[q] = gain * v + z * before[q];
        store(before[q], sample(k, q));
      }
    Lanes after[kVectors];
    for (int q = 0; q < kVectors; ++q) {
      Lanes other;
      load(sample(n - 2, q), other);
      after[q] = z / (z * z - 1) * (before[q] + z * other);
      store(after[q], sample(n - 1, q));
    }
    for (int k = n - 2; k >= 0; --k)
      for (int q = 0; q < kVectors; ++q) {
        Lanes v;
        load(sample(k, q), v);
        after[q] = z * (after[q] - v);
        store(after[q], sample(k, q));
      }
  }
}

/// The same of each column, some at a time.
void prefilter_columns(cv::Mat samples) {
  cv::Mat panel(samples.rows, kPanel, CV_32F, cv::Scalar(0));
  for (int x = 0; x < samples.cols; x += kPanel) {
    cv::Mat columns = samples.colRange(x, std::min(x + kPanel, samples.cols)),
            filled = panel.colRange(0, columns.cols);
    columns.copyTo(filled);
    prefilter_panel(panel.ptr<float>(), samples.rows);
    filled.copyTo(columns);
  }
}

TRIBOTRACK_KERNEL void along_rows(const float* c, std::ptrdiff_t stride, const std::array<float, 6>& w,
                                  std::size_t rows, std::size_t line, float* out) {
  for (std::size_t j = 0; j < rows; ++j, c += stride, out += line)
    for (std::size_t i = 0; i < line; ++i)
      out[i] = w[0] * c[i] + w[1] * c[i + 1] + w[2] * c[i + 2] + w[3] * c[i + 3] + w[4] * c[i + 4] +
               w[5] * c[i + 5];
}

TRIBOTRACK_KERNEL void along_columns(const float* r, const std::array<float, 6>& w, std::size_t rows,
                                     std::size_t line, float* out) {
  for (std::size_t j = 0; j < rows; ++j, r += line, out += line)
    for (std::size_t i = 0; i < line; ++i)
      out[i] = w[0] * r[i] + w[1] * r[i + line] + w[2] * r[i + 2 * line] + w[3] * r[i + 3 * line] +
               w[4] * r[i + 4 * line] + w[5] * r[i + 5 * line];
}

/// out[j * width + i] for a window whose first place lies in the cell of the coefficient at `corner`; rows of
/// coefficients are `stride` apart.
TRIBOTRACK_CLONES void window_of(const float* corner, std::ptrdiff_t stride, const SplineTaps& taps,
                                 int width, int height, std::vector<float>& scratch, float* value,
                                 float* slope_x, float* slope_y) {
  const auto line = static_cast<std::size_t>(width);
  const auto lines = static_cast<std::size_t>(height);
  const std::size_t rows = lines + 5;
  if (scratch.size() < 2 * rows * line) scratch.resize(2 * rows * line);
  float* smooth = scratch.data();
  float* slanted = smooth + rows * line;
  const float* first = corner - 2 * stride - 2;
  along_rows(first, stride, taps.weight_x, rows, line, smooth);
  along_columns(smooth, taps.weight_y, lines, line, value);
  if (slope_y) along_columns(smooth, taps.slope_y, lines, line, slope_y);
  if (!slope_x) return;
  along_rows(first, stride, taps.slope_x, rows, line, slanted);
  along_columns(slanted, taps.weight_y, lines, line, slope_x);
}

// The six weights of a quintic B-spline in one vector, for places that each have a fraction of their own.

using TapLanes = VectorOf<float, 8>::type;  ///< weights of the coefficients -2 .. 3, then two zeros

TRIBOTRACK_KERNEL float whole_below(float x) {
  const auto cut = static_cast<float>(static_cast<int>(x));
  return cut > x ? cut - 1 : cut;
}

/// b(t - k), t in [0, 1), each a polynomial of t: all six at once by Horner's rule.
template <class Number, class Taps>
TRIBOTRACK_KERNEL void quintic_lanes(Number t, Taps& weight) {
  constexpr Number u = Number(1) / 120;
  constexpr Taps c5 = {-u, 5 * u, -10 * u, 10 * u, -5 * u, u, 0, 0};
  constexpr Taps c4 = {5 * u, -20 * u, 30 * u, -20 * u, 5 * u, 0, 0, 0};
  constexpr Taps c3 = {-10 * u, 20 * u, 0, -20 * u, 10 * u, 0, 0, 0};
  constexpr Taps c2 = {10 * u, 20 * u, -60 * u, 20 * u, 10 * u, 0, 0, 0};
  constexpr Taps c1 = {-5 * u, -50 * u, 0, 50 * u, 5 * u, 0, 0, 0};
  constexpr Taps c0 = {u, 26 * u, 66 * u, 26 * u, u, 0, 0, 0};
  weight = ((((c5 * t + c4) * t + c3) * t + c2) * t + c1) * t + c0;
}

/// Their derivatives with respect to t.
template <class Number, class Taps>
TRIBOTRACK_KERNEL void quintic_slope_lanes(Number t, Taps& slope) {
  constexpr Number u = Number(1) / 24;
  constexpr Taps c4 = {-u, 5 * u, -10 * u, 10 * u, -5 * u, u, 0, 0};
  constexpr Taps c3 = {4 * u, -16 * u, 24 * u, -16 * u, 4 * u, 0, 0, 0};
  constexpr Taps c2 = {-6 * u, 12 * u, 0, -12 * u, 6 * u, 0, 0, 0};
  constexpr Taps c1 = {4 * u, 8 * u, -24 * u, 8 * u, 4 * u, 0, 0, 0};
  constexpr Taps c0 = {-u, -10 * u, 0, 10 * u, u, 0, 0, 0};
  slope = (((c4 * t + c3) * t + c2) * t + c1) * t + c0;
}

/// sum_j y_j c_ij of each column i of the six by six coefficients whose first is at `c`; eight of a row are
/// read.
TRIBOTRACK_KERNEL void weigh_rows(const float* c, std::ptrdiff_t stride, const TapLanes& weight_y,
                                  TapLanes& columns) {
  columns = TapLanes{};
  for (int j = 0; j < 6; ++j) {
    TapLanes row;
    load(c + j * stride, row);
    columns += weight_y[j] * row;
  }
}

/// Of the eight numbers.
TRIBOTRACK_KERNEL float sum_of_lanes(const TapLanes& v) {
  return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]));
}

/// b(t - k) for k = -2 .. 3, t in [0, 1): weights of the six coefficients around t.
std::array<double, 6> quintic_weights(double t) {
  VectorOf<double, 8>::type w;
  quintic_lanes(t, w);
  return {w[0], w[1], w[2], w[3], w[4], w[5]};
}

/// Their derivatives by t.
std::array<double, 6> quintic_slopes(double t) {
  VectorOf<double, 8>::type s;
  quintic_slope_lanes(t, s);
  return {s[0], s[1], s[2], s[3], s[4], s[5]};
}

}  // namespace

SplineTaps spline_taps(double fraction_x, double fraction_y) {
  const auto narrow = [](const std::array<double, 6>& from) {
    std::array<float, 6> to{};
    std::transform(from.begin(), from.end(), to.begin(), [](double v) { return static_cast<float>(v); });
    return to;
  };
  return {narrow(quintic_weights(fraction_x)), narrow(quintic_slopes(fraction_x)),
          narrow(quintic_weights(fraction_y)), narrow(quintic_slopes(fraction_y))};
}

QuinticSpline::QuinticSpline(const Picture& picture)
    : width_(picture.width()), height_(picture.height()), stride_(picture.width() + 2 * kPad) {
  coefficients_.resize(static_cast<std::size_t>(stride_) * (height_ + 2 * kPad));
  cv::Mat padded(height_ + 2 * kPad, stride_, CV_32F, coefficients_.data()), turned;
  cv::Mat inner = padded({kPad, kPad, width_, height_});
  cv::transpose(matrix_of(picture), turned);
  prefilter_columns(turned);
  cv::transpose(turned, inner);
  prefilter_columns(inner);
  cv::copyMakeBorder(inner, padded, kPad, kPad, kPad, kPad, cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
}

SplineSample QuinticSpline::sample(double x, double y) const {
  x = std::clamp(x, -5.0, width_ + 3.999);
  y = std::clamp(y, -5.0, height_ + 3.999);
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  const auto wx = quintic_weights(x - fx);
  const auto sx = quintic_slopes(x - fx);
  const auto wy = quintic_weights(y - fy);
  const auto sy = quintic_slopes(y - fy);
  SplineSample out;
  for (int j = 0; j < 6; ++j) {
    const float* row = coefficient_row(static_cast<int>(fy) + j - 2) + static_cast<int>(fx) - 2;
    double value = 0;
    double slope = 0;
    for (std::size_t i = 0; i < 6; ++i) {
      value += wx[i] * row[i];
      slope += sx[i] * row[i];
    }
    out.value += wy[static_cast<std::size_t>(j)] * value;
    out.slope_x += wy[static_cast<std::size_t>(j)] * slope;
    out.slope_y += sy[static_cast<std::size_t>(j)] * value;
  }
  return out;
}

TRIBOTRACK_CLONES void QuinticSpline::sample_places(const std::vector<float>& x, const std::vector<float>& y,
                                                    float* value, float* slope_x, float* slope_y) const {
  const float right = static_cast<float>(width_) + 3.99F, bottom = static_cast<float>(height_) + 3.99F;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const float at_x = std::min(std::max(x[k], -5.0F), right);
    const float at_y = std::min(std::max(y[k], -5.0F), bottom);
    const float fx = whole_below(at_x), fy = whole_below(at_y);
    const float* corner = coefficient(static_cast<int>(fx) - 2, static_cast<int>(fy) - 2);
    TapLanes across, down, columns;
    quintic_lanes(at_x - fx, across);
    quintic_lanes(at_y - fy, down);
    weigh_rows(corner, stride_, down, columns);
    value[k] = sum_of_lanes(columns * across);
    if (!slope_x) continue;
    TapLanes rise;
    quintic_slope_lanes(at_x - fx, rise);
    slope_x[k] = sum_of_lanes(columns * rise);
    quintic_slope_lanes(at_y - fy, rise);
    weigh_rows(corner, stride_, rise, columns);
    slope_y[k] = sum_of_lanes(columns * across);
  }
}

void QuinticSpline::sample_window(double x0, double y0, int width, int height, float* value, float* slope_x,
                                  float* slope_y) const {
  const int ix = static_cast<int>(std::floor(x0));
  const int iy = static_cast<int>(std::floor(y0));
  thread_local std::vector<float> rows;
  window_of(coefficient(ix, iy), stride_, spline_taps(x0 - ix, y0 - iy), width, height, rows, value, slope_x,
            slope_y);
}

void QuinticSpline::sample_tiles(double x0, double y0, const std::vector<TilePlace>& tiles,
                                 std::vector<const float*>& corners, float pivot, bool slopes,
                                 TileArrays& arrays, std::size_t tile, std::size_t end) const {
  const int ix = static_cast<int>(std::floor(x0));
  const int iy = static_cast<int>(std::floor(y0));
  end = std::min(end, tiles.size());
  for (std::size_t t = tile; t < end; ++t) corners[t] = coefficient(ix + tiles[t].x, iy + tiles[t].y);
  vision::sample_tiles(corners, stride_, spline_taps(x0 - ix, y0 - iy), pivot, slopes, arrays, tile, end);
}

namespace {

constexpr int kReach = 20;  // 0.43^20 < 1e-7

/// Sum over k of h_k h_{k + lag}, h the coefficients of a picture that is 1 at one pixel and else 0.
double autocorrelation(int lag) {
  static const std::vector<double> known = [] {
    constexpr int length = 6 * kReach + 1;
    Picture line(length, 1);
    line.at(3 * kReach, 0) = 1;
    const QuinticSpline spline(line);
    const float* h = spline.coefficient(0, 0);
    std::vector<double> sums(2 * kReach + 1, 0.0);
    for (int l = 0; l <= 2 * kReach; ++l)
      for (int k = 0; k + l < length; ++k)
        sums[static_cast<std::size_t>(l)] += static_cast<double>(h[k]) * static_cast<double>(h[k + l]);
    return sums;
  }();
  const auto place = static_cast<std::size_t>(std::abs(lag));
  return place < known.size() ? known[place] : 0;
}

/// Covariance of white noise interpolated with these weights, the second's first coefficient `shift` beyond
/// the first's.
double covariance(const std::array<double, 6>& a, const std::array<double, 6>& b, int shift) {
  std::array<double, 11> of_lag{};
  for (int l = 0; l < 11; ++l) of_lag[static_cast<std::size_t>(l)] = autocorrelation(shift + l - 5);
  double sum = 0;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) sum += a[i] * b[j] * of_lag[j + 5 - i];
  return sum;
}

}  // namespace

InterpolationNoise quintic_noise(double f, double g) {
  const int shift = static_cast<int>(std::floor(g) - std::floor(f));
  const double t = f - std::floor(f), u = g - std::floor(g);
  const auto there = quintic_weights(u), slopes = quintic_slopes(t);
  return {covariance(quintic_weights(t), there, shift), covariance(slopes, there, shift),
          covariance(slopes, quintic_slopes(u), shift)};
}

}  // namespace tribotrack::vision
