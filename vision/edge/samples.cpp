#include "vision/edge/rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tribotrack::vision {
namespace {

constexpr double kAlike = 6;       ///< px of the rim over which fields have like variances
constexpr double kOfLevels = 0.1;  ///< grey levels^2 of an average over rays that no field explains
constexpr int kIterations = 20;    ///< of the variances, for each optics tried
constexpr double kEdgeReach = 1.25, kCoarse = 0.5, kFine = 0.1;  ///< px about the circle given; steps
constexpr double kSharpest = 0.4;                                ///< px: a pixel alone blurs by 0.29
constexpr double kWidestChamfer = 0.08;                          ///< of the radius

/// Weighted means of what each ray gives.
std::vector<Eigen::MatrixXd> over_sectors(const std::vector<Eigen::MatrixXf>& of_ray) {
  const auto n = static_cast<double>(of_ray.size());
  const double width = std::max(kAlike, n / (2 * kSectors));
  std::vector<Eigen::MatrixXd> out;
  for (std::size_t j = 0; j < kSectors; ++j) {
    const double middle = static_cast<double>(j) * n / kSectors;
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(of_ray.front().rows(), of_ray.front().cols());
    double total = 0;
    for (std::size_t p = 0; p < of_ray.size(); ++p) {
      double apart = std::abs(static_cast<double>(p) - middle);
      apart = std::min(apart, n - apart);
      if (apart > 3 * width) continue;
      const double weight = std::exp(-0.5 * std::pow(apart / width, 2));
      sum += weight * of_ray[p].cast<double>();
      total += weight;
    }
    out.push_back(sum / total);
  }
  return out;
}

/// Of `frames` frames of levels, the products of the places along each ray.
std::vector<Eigen::MatrixXd> mean_products(const RayGrid& grid, const std::vector<float>& levels,
                                           std::size_t frames) {
  const auto places = static_cast<Eigen::Index>(grid.places());
  std::vector<Eigen::MatrixXf> of_ray;
  for (int p = 0; p < grid.azimuths; ++p) {
    const Eigen::Map<const Eigen::MatrixXf, 0, Eigen::OuterStride<>> ray(
        levels.data() + p * places, places, static_cast<Eigen::Index>(frames),
        Eigen::OuterStride<>(static_cast<Eigen::Index>(grid.size())));
    of_ray.emplace_back(ray * ray.transpose() / static_cast<float>(frames));
  }
  return over_sectors(of_ray);
}

/// -2 log of the likelihood of a rim's optics, per ray.
double cost_of(const RayFields& fields, const RimOptics& optics, std::span<const RaySamples> samples,
               RayFields::Beside beside) {
  const std::vector<Eigen::MatrixXd> pieces = fields.covariances(optics, beside);
  double sum = 0;
  for (const RaySamples& sample : samples) {
    Eigen::VectorXd start;
    sum += fit_variances(sample.covariances.front(), pieces, sample.noise_variance, kIterations, start);
  }
  return sum;
}

}  // namespace

RaySamples all_round(const RaySamples& sectors) {
  Eigen::MatrixXd sum = sectors.covariances.front();
  for (std::size_t j = 1; j < kSectors; ++j) sum += sectors.covariances[j];
  return {{sum / kSectors}, sectors.noise_variance + kOfLevels};
}

RaySamples samples_of_mean(const RayGrid& grid, const std::vector<float>& mean, double noise_variance,
                           std::size_t frames) {
  return all_round({mean_products(grid, mean, 1), noise_variance / static_cast<double>(frames)});
}

std::vector<RaySamples> samples_of_bands(const RayGrid& grid, const std::vector<float>& levels,
                                         double noise_variance, std::span<const std::size_t> block_ends) {
  const Bands bands = split_bands(levels, grid.size(), block_ends);
  const std::array<double, kBands> shares = noise_shares(block_ends);
  std::vector<RaySamples> out;
  for (std::size_t b = 0; b < kBands; ++b)
    out.push_back({mean_products(grid, bands[b], block_ends.back()), noise_variance * shares[b]});
  return out;
}

std::vector<RimOptics> optics_about(const RimOptics& start, double radius) {
  std::vector<RimOptics> out;
  for (double chamfer = 0; chamfer < kWidestChamfer * radius; chamfer = std::max(0.5, 2 * chamfer))
    for (double edge = -kEdgeReach; edge <= kEdgeReach + chamfer; edge += kCoarse)
      out.push_back({edge, start.blur, chamfer});
  return out;
}

LikeliestOptics likeliest_optics(const RayFields& fields, std::span<const RaySamples> samples,
                                 const std::vector<RimOptics>& starts, RayFields::Beside beside,
                                 double widest) {
  LikeliestOptics found{starts.front(), std::numeric_limits<double>::infinity()};
  const RimOptics& best = found.optics;
  const auto improves = [&](const RimOptics& trial) {
    if (trial.blur < kSharpest || trial.chamfer < 0 || trial.chamfer > widest) return false;
    const double cost = cost_of(fields, trial, samples, beside);
    if (!(cost < found.cost)) return false;
    found = {trial, cost};
    return true;
  };
  for (const RimOptics& start : starts) improves(start);
  for (double step = kCoarse; step > kFine; step /= 2)
    for (bool moved = true; moved;) {
      moved = false;
      for (const double d : {-step, step}) {
        moved |= improves({best.edge + d, best.blur, best.chamfer});
        moved |= improves({best.edge, best.blur * (1 + 0.5 * d), best.chamfer});
        moved |= improves({best.edge, best.blur, best.chamfer + d});
        moved |= improves({best.edge + d / 2, best.blur, best.chamfer + d});  // the inner edge stays
      }
    }
  return found;
}

namespace {

/// Frames on either side of running means, each taken three times: about Gaussian windows of 3 and 9 frames.
/// The result is not delicate in them.
constexpr std::size_t kShort = 3, kLong = 9;
constexpr int kTimes = 3;

/// Means over rows k - half .. k + half, as far as there are such.
void running_mean(std::span<float> rows, std::size_t width, std::size_t half) {
  const std::size_t n = rows.size() / width;
  const std::vector<float> before(rows.begin(), rows.end());
  std::vector<double> sum(width, 0);
  std::size_t begin = 0, end = 0;
  for (std::size_t k = 0; k < n; ++k) {
    for (; end < std::min(n, k + half + 1); ++end)
      for (std::size_t i = 0; i < width; ++i) sum[i] += before[end * width + i];
    for (; begin + half < k; ++begin)
      for (std::size_t i = 0; i < width; ++i) sum[i] -= before[begin * width + i];
    const double share = 1.0 / static_cast<double>(end - begin);
    for (std::size_t i = 0; i < width; ++i) rows[k * width + i] = static_cast<float>(share * sum[i]);
  }
}

std::vector<float> smoothed(std::vector<float> series, std::size_t width,
                            std::span<const std::size_t> block_ends, std::size_t half) {
  std::size_t begin = 0;
  for (const std::size_t end : block_ends) {
    for (int time = 0; time < kTimes; ++time)
      running_mean(std::span(series).subspan(begin * width, (end - begin) * width), width, half);
    begin = end;
  }
  return series;
}

}  // namespace

Bands split_bands(const std::vector<float>& series, std::size_t width,
                  std::span<const std::size_t> block_ends) {
  Bands bands = {series, smoothed(series, width, block_ends, kShort),
                 smoothed(series, width, block_ends, kLong)};
  for (std::size_t b = 0; b + 1 < kBands; ++b)
    for (std::size_t i = 0; i < series.size(); ++i) bands[b][i] -= bands[b + 1][i];
  return bands;
}

std::array<double, kBands> noise_shares(std::span<const std::size_t> block_ends) {
  std::array<double, kBands> shares{};
  std::size_t begin = 0;
  std::vector<std::size_t> lengths;
  for (const std::size_t end : block_ends) {
    const std::size_t n = end - begin;
    begin = end;
    // A unit in each row, one after the other; far from the ends all answers are alike.
    const std::size_t rows = std::min(n, 8 * kLong * kTimes), only[] = {rows};
    std::vector<float> units(rows * rows, 0);
    for (std::size_t k = 0; k < rows; ++k) units[k * rows + k] = 1;
    const Bands bands = split_bands(units, rows, only);
    for (std::size_t b = 0; b < kBands; ++b) {
      double squares = 0;
      for (const float v : bands[b]) squares += static_cast<double>(v) * v;
      shares[b] += squares / static_cast<double>(rows) * static_cast<double>(n) /
                   static_cast<double>(block_ends.back());
    }
  }
  return shares;
}

}  // namespace tribotrack::vision
