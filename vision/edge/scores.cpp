
#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/edge/rays.h"
#include "vision/kernels/dense.h"

namespace tribotrack::vision {
namespace {

/// Lamps leave patterns of low azimuthal order, which resemble a shift more than independent rays would.
constexpr std::array<double, kBands> kLowOrders = {1, 8, 8};
constexpr std::size_t kRun = 64;  ///< frames either way that share a covariance

std::size_t sector_of(const RayGrid& grid, int azimuth) {
  return static_cast<std::size_t>(azimuth) * kSectors / static_cast<std::size_t>(grid.azimuths);
}

template <class Numbers>
auto of_band(Numbers& bands, std::size_t band, std::size_t frame) {
  return bands[band].data() + frame * kScores + band * kSectors * 2;
}

/// Takes the shift out of a frame's scores, and gives the covariance of a shift for what is left of them.
Eigen::Matrix2d take_out(const BandWeights& weights, const Eigen::Vector2d& shift, float* of_sectors) {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (std::size_t j = 0; j < kSectors; ++j) {
    float* z = of_sectors + 2 * j;
    const Eigen::Vector2d left = Eigen::Vector2d(z[0], z[1]) + weights.information[j] * shift;
    z[0] = static_cast<float>(left(0));
    z[1] = static_cast<float>(left(1));
    sum += left * left.transpose();
  }
  // A shift has taken two numbers.
  return weights.shift_per_score * sum * weights.shift_per_score.transpose() * (kSectors / (kSectors - 2.0));
}

/// How much more than independent sectors the scores left of a band vary in the azimuthal order of a shift,
/// which cannot be seen: by the orders next to it, whose powers are interpolated geometrically. A level that
/// changes beside an edge that is not quite where it is taken to be shows as order 0.
double low_order_excess(const Bands& bands, std::size_t band, std::size_t frames) {
  double round = 0, low = 0, white = 0;
  for (std::size_t i = 0; i < frames; ++i) {
    const float* z = of_band(bands, band, i);
    std::array<Eigen::Vector2d, 4> sum;
    sum.fill(Eigen::Vector2d::Zero());
    for (std::size_t j = 0; j < kSectors; ++j) {
      const double phi = 2 * std::numbers::pi * (static_cast<double>(j) + 0.5) / kSectors;
      const double radial = z[2 * j] * std::cos(phi) + z[2 * j + 1] * std::sin(phi);
      for (const int order : {0, 2, 3})
        sum[static_cast<std::size_t>(order)] +=
            radial * Eigen::Vector2d(std::cos(order * phi), std::sin(order * phi));
      white += radial * radial;
    }
    round += sum[0].squaredNorm();
    low += 0.5 * (sum[2].squaredNorm() + sum[3].squaredNorm());
  }
  const double most = std::max({white, low, std::sqrt(round * low)});
  return white > 0 ? most / white : 1;
}

/// Frames over which the slow band stays alike: where its correlation has fallen to 1 / e.
double frames_alike(const Bands& bands, std::size_t frames) {
  double at_once = 0;
  for (std::size_t lag = 0; lag < frames; lag += std::max<std::size_t>(1, lag / 8)) {
    double sum = 0;
    for (std::size_t k = 0; k + lag < frames; ++k) {
      const float *a = of_band(bands, kBands - 1, k), *b = of_band(bands, kBands - 1, k + lag);
      for (std::size_t j = 0; j < 2 * kSectors; ++j)
        sum += static_cast<double>(a[j]) * static_cast<double>(b[j]);
    }
    sum /= static_cast<double>(frames - lag);
    if (lag == 0) at_once = sum;
    if (sum < at_once / std::numbers::e) return static_cast<double>(lag);
  }
  return static_cast<double>(frames);
}

/// Means over the frames about each.
std::vector<Eigen::Matrix2d> about_each(const std::vector<Eigen::Matrix2d>& of_frame) {
  std::vector<Eigen::Matrix2d> sums = {Eigen::Matrix2d::Zero()}, out;
  for (const Eigen::Matrix2d& v : of_frame) sums.push_back(sums.back() + v);
  for (std::size_t i = 0; i < of_frame.size(); ++i) {
    const std::size_t first = i < kRun ? 0 : i - kRun, last = std::min(of_frame.size(), i + kRun + 1);
    out.push_back((sums[last] - sums[first]) / static_cast<double>(last - first));
  }
  return out;
}

}  // namespace

BandWeights weigh(const RayGrid& grid, const MeanRays& mean, const std::vector<Eigen::MatrixXd>& fields,
                  const std::array<Eigen::VectorXd, kSectors>& variances, std::size_t band,
                  double noise_variance) {
  const auto places = static_cast<Eigen::Index>(grid.places());
  BandWeights out;
  out.x.resize(grid.size());
  out.y.resize(grid.size());
  out.information.fill(Eigen::Matrix2d::Zero());
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (int p = 0; p < grid.azimuths; ++p) {
    const double at = static_cast<double>(p) * kSectors / grid.azimuths, share = at - std::floor(at);
    const auto j = static_cast<std::size_t>(at);
    const Eigen::VectorXd v = (1 - share) * variances[j] + share * variances[(j + 1) % kSectors];
    Eigen::MatrixXd covariance = kLowOrders[band] * field_covariance(fields, v);
    covariance.diagonal().array() += noise_variance;
    const auto ray = [&](auto& of) {
      return Eigen::Map<const Eigen::VectorXf>(of.data() + p * places, places);
    };
    Eigen::MatrixXd gradient(places, 2);
    gradient.col(0) = ray(mean.slope_x).template cast<double>();
    gradient.col(1) = ray(mean.slope_y).template cast<double>();
    const Eigen::MatrixXd weight = solve_spd(covariance, gradient);
    Eigen::Map<Eigen::VectorXf>(out.x.data() + p * places, places) = weight.col(0).cast<float>();
    Eigen::Map<Eigen::VectorXf>(out.y.data() + p * places, places) = weight.col(1).cast<float>();
    const Eigen::Matrix2d information = weight.transpose() * gradient;
    out.information[sector_of(grid, p)] += information;
    sum += information;
  }
  out.shift_per_score = inverse_of(FewByFew(sum));
  return out;
}

void score(const RayGrid& grid, const EdgeWeights& weights, const float* levels, float* scores) {
  const std::size_t places = grid.places();
  std::fill(scores, scores + kScores, 0.0F);
  for (int p = 0; p < grid.azimuths; ++p) {
    const std::size_t first = static_cast<std::size_t>(p) * places;
    for (std::size_t b = 0; b < kBands; ++b) {
      float x = 0, y = 0;
      for (std::size_t i = first; i < first + places; ++i) {
        x += levels[i] * weights[b].x[i];
        y += levels[i] * weights[b].y[i];
      }
      float* to = scores + 2 * (b * kSectors + sector_of(grid, p));
      to[0] += x;
      to[1] += y;
    }
  }
}

Eigen::Vector2d shift(const BandWeights& weights, const float* of_sectors) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t j = 0; j < kSectors; ++j) sum += Eigen::Vector2d(of_sectors[2 * j], of_sectors[2 * j + 1]);
  return -(weights.shift_per_score * sum);
}

std::vector<Eigen::Vector2d> shifts_by_bands(const EdgeWeights& weights, const Bands& scores) {
  std::vector<Eigen::Vector2d> out(scores[0].size() / kScores, Eigen::Vector2d::Zero());
  for (std::size_t b = 0; b < kBands; ++b)
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += shift(weights[b], of_band(scores, b, i));
  return out;
}

ScoredShifts scored_shifts(const EdgeWeights& weights, const std::vector<float>& scores) {
  const std::size_t n = scores.size() / kScores, whole[] = {n};
  Bands bands = split_bands(scores, kScores, whole);
  ScoredShifts out{shifts_by_bands(weights, bands), std::vector(n, Eigen::Matrix2d(Eigen::Matrix2d::Zero()))};
  for (std::size_t b = 0; b < kBands; ++b) {
    std::vector<Eigen::Matrix2d> of_frame;
    for (std::size_t i = 0; i < n; ++i) {
      float* z = of_band(bands, b, i);
      of_frame.push_back(take_out(weights[b], shift(weights[b], z), z));
    }
    const double excess = low_order_excess(bands, b, n);
    const bool slow = b + 1 == kBands;
    if (slow) {  // lasts as long as the recording: one for all
      Eigen::Matrix2d mean = Eigen::Matrix2d::Zero();
      for (const Eigen::Matrix2d& v : of_frame) mean += v / static_cast<double>(n);
      of_frame.assign(n, mean);
      out.slow_sd = std::sqrt(0.5 * excess * mean.trace());
      out.slow_frames = frames_alike(bands, n);
    } else {
      of_frame = about_each(of_frame);
    }
    for (std::size_t i = 0; i < n; ++i) out.covariance[i] += excess * of_frame[i];
  }
  return out;
}

}  // namespace tribotrack::vision
