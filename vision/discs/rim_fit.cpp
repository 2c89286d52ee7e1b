#include "vision/discs/rim_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::array<int, 4> kCurved = {7, 8, 9, 13};  ///< that only large discs have
constexpr double kCurvedRadius = 12;     ///< px; smaller discs have too few pixels inside their rim
constexpr double kCurvedMeanRadius = 7;  ///< px; likewise for the mean radius
constexpr double kSectorRadius = 5;      ///< px; smaller rims have too few pixels for sectors
constexpr int kRounds = 4;               ///< of weights, the first all alike
constexpr double kOnTheWay = 1e-3, kTolerance = 1e-5;  ///< px: the last step of a round, of the last one
constexpr int kSteps = 25;                             ///< for given weights, at most
constexpr double kTukey = 6;                           ///< sd: what is further off does not count

/// The model at a pixel and, if wanted, its slopes.
double rim_model(const RimParameters& p, double x, double y, RimParameters* slope) {
  const double radius = p(2), s = p(3), dx = x - p(0), dy = y - p(1);
  const double rho = std::sqrt(std::max(1e-18, dx * dx + dy * dy));
  const double t = (radius - s * s / (2 * radius) - rho) / s;
  const double value = 0.5 * std::erfc(-t / std::numbers::sqrt2);
  const double u = dx / radius, v = dy / radius, uu = u * u, uv = u * v, vv = v * v;
  const double out = p(10) + p(11) * u + p(12) * v + p(13) * (uu + vv);
  const double step = p(4) + p(5) * u + p(6) * v + p(7) * uu + p(8) * uv + p(9) * vv - out;
  if (slope) {
    const double rise = step * std::exp(-0.5 * t * t) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
    const double along = rise / (s * rho), outside = 1 - value;
    *slope << along * dx, along * dy, rise * (1 / s + s / (2 * radius * radius)),
        -rise * (t / s + 1 / radius), value, value * u, value * v, value * uu, value * uv, value * vv,
        outside, outside * u, outside * v, outside * (uu + vv);
  }
  return out + step * value;
}

/// Of r = I - model with its slopes g: sum w g g^T, sum w r g, sum w r^2.
struct RimSums {
  RimCovariance normal;
  RimParameters gradient;
  double cost = 0;
};

/// What small discs do not have is held.
RimSums normal_equations(const RimParameters& p, const RimPixels& pixels, bool curved) {
  constexpr int columns = kRimParameters + 1, together = 64;
  Eigen::Matrix<double, columns, columns> sums = Eigen::Matrix<double, columns, columns>::Zero();
  Eigen::Matrix<double, columns, together> block;
  RimParameters slope;
  int filled = 0;
  for (std::size_t i = 0; i < pixels.x.size(); ++i) {
    if (pixels.weight[i] > 0) {
      const double root = std::sqrt(pixels.weight[i]);
      const double model = rim_model(p, pixels.x[i], pixels.y[i], &slope);
      block.col(filled).head<kRimParameters>() = root * slope;
      block(kRimParameters, filled++) = root * (pixels.level[i] - model);
    }
    if (filled < together && i + 1 < pixels.x.size()) continue;
    sums.selfadjointView<Eigen::Lower>().rankUpdate(block.leftCols(filled));
    filled = 0;
  }
  sums.triangularView<Eigen::StrictlyUpper>() = sums.transpose();
  RimSums out{sums.topLeftCorner<kRimParameters, kRimParameters>(),
              sums.col(kRimParameters).head<kRimParameters>(), sums(kRimParameters, kRimParameters)};
  if (!curved)
    for (const int i : kCurved) {
      out.normal.row(i).setZero();
      out.normal.col(i).setZero();
      out.normal(i, i) = 1;
      out.gradient(i) = 0;
    }
  return out;
}

std::vector<double> rim_residuals(const RimParameters& p, const RimPixels& pixels) {
  std::vector<double> out;
  for (std::size_t i = 0; i < pixels.x.size(); ++i)
    out.push_back(pixels.level[i] - rim_model(p, pixels.x[i], pixels.y[i], nullptr));
  return out;
}

/// For given weights, from p, which it changes. Returns the last normal matrix.
RimCovariance settle(RimParameters& p, const RimPixels& pixels, bool curved, double tolerance,
                     double& damping) {
  RimSums at = normal_equations(p, pixels, curved);
  for (int k = 0; k < kSteps; ++k) {
    bool improved = false;
    for (int tries = 0; tries < 8 && !improved; ++tries) {
      RimCovariance damped = at.normal;
      damped.diagonal() *= 1 + damping;
      const RimParameters step = damped.ldlt().solve(at.gradient);
      RimParameters trial = p + step;
      trial(3) = std::clamp(trial(3), 0.3, 0.5 * std::max(1.0, trial(2)));
      if (step.head<4>().cwiseAbs().maxCoeff() < tolerance) {
        p = trial;
        return at.normal;
      }
      if (trial(2) > 1) {
        RimSums there = normal_equations(trial, pixels, curved);
        improved = there.cost <= at.cost;
        if (improved) {
          p = trial;
          at = there;
        }
      }
      damping = improved ? std::max(1e-9, damping / 10) : damping * 10;
    }
    if (!improved) break;
  }
  return at.normal;
}

struct Influence {
  double weight = 0, square = 0, slope = 0;  ///< sums of w, psi^2, psi'
  double weighted_square = 0;
};

/// Tukey's weights by the pixels' residuals.
Influence weigh(const std::vector<double>& residuals, RimPixels& pixels) {
  std::vector<double> sizes(residuals.size());
  std::ranges::transform(residuals, sizes.begin(), [](double r) { return std::abs(r); });
  const double scale = std::max(0.3, kNormalMad * median(sizes));
  Influence sums;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const double t = residuals[i] / (kTukey * scale), rest = std::max(0.0, 1 - t * t);
    const double weight = rest * rest, square = residuals[i] * residuals[i];
    pixels.weight[i] = weight;
    sums.weight += weight;
    sums.weighted_square += weight * square;
    sums.square += weight * weight * square;
    sums.slope += rest * (1 - 5 * t * t);
  }
  return sums;
}

/// What the residuals of each sector of the rim do to the radius: -(N^-1 sum w g r)_R.
std::vector<double> sector_pull(const RimPixels& pixels, const RimParameters& p,
                                const RimCovariance& inverse_normal) {
  if (p(2) < kSectorRadius) return {};
  std::vector<double> pull(kSectors, 0);
  RimParameters slope;
  for (std::size_t i = 0; i < pixels.x.size(); ++i) {
    const double off = pixels.level[i] - rim_model(p, pixels.x[i], pixels.y[i], &slope);
    const double turn = 0.5 + std::atan2(pixels.y[i] - p(1), pixels.x[i] - p(0)) / (2 * kPi);
    pull[std::min(static_cast<std::size_t>(turn * kSectors), kSectors - 1)] +=
        pixels.weight[i] * off * inverse_normal.row(2).dot(slope);
  }
  return pull;
}

}  // namespace

RimPixels rim_pixels(const Picture& picture, const Circle& c, double band) {
  RimPixels pixels;
  const auto expected = static_cast<std::size_t>(std::max(0.0, 4.2 * kPi * c.radius * band) + 64);
  for (auto* v : {&pixels.x, &pixels.y, &pixels.level}) v->reserve(expected);
  const double reach = c.radius + band;
  const int x0 = std::max(0, static_cast<int>(std::floor(c.x - reach)));
  const int x1 = std::min(picture.width() - 1, static_cast<int>(std::ceil(c.x + reach)));
  const int y0 = std::max(0, static_cast<int>(std::floor(c.y - reach)));
  const int y1 = std::min(picture.height() - 1, static_cast<int>(std::ceil(c.y + reach)));
  const double least = std::pow(std::max(0.0, c.radius - band), 2), most = reach * reach;
  for (int y = y0; y <= y1; ++y) {
    const float* row = picture.row(y).data();
    const double across = (y - c.y) * (y - c.y);
    // Left of the inner circle and right of it; without one, all at once.
    const double half = across < least ? std::sqrt(least - across) : 0;
    const int left = std::clamp(static_cast<int>(std::ceil(c.x - half)) + 1, x0, x1 + 1);
    const int right = std::clamp(static_cast<int>(std::floor(c.x + half)) - 1, left, x1 + 1);
    const auto add = [&](int from, int to) {
      for (int x = from; x < to; ++x) {
        const double square = (x - c.x) * (x - c.x) + across;
        if (square < least || square > most) continue;
        pixels.x.push_back(x);
        pixels.y.push_back(y);
        pixels.level.push_back(static_cast<double>(row[x]));
      }
    };
    add(x0, left);
    add(right, x1 + 1);
  }
  pixels.weight.assign(pixels.x.size(), 1);
  return pixels;
}

bool rim_curves(const RimParameters& p, RimUse use) {
  return p(2) >= (use == RimUse::place ? kCurvedRadius : kCurvedMeanRadius);
}

double rim_band(const RimParameters& p, bool curved) {
  const double band = std::min(std::clamp(4.5 * p(3), 4.0, 30.0), 0.6 * p(2));
  // The slope of a level that may curve must be fixed by pixels.
  return curved ? std::max(band, std::min(std::clamp(6.5 * p(3), 5.5, 30.0), 0.35 * p(2))) : band;
}

RimFit fit_rim(RimPixels& pixels, const RimParameters& start, bool curved) {
  RimFit fit;
  fit.p = start;
  double damping = 1e-3;
  RimCovariance normal;
  Influence influence;
  for (int round = 0; round < kRounds; ++round) {
    normal = settle(fit.p, pixels, curved, round + 1 < kRounds ? kOnTheWay : kTolerance, damping);
    influence = weigh(rim_residuals(fit.p, pixels), pixels);
  }
  fit.residual_rms = std::sqrt(influence.weighted_square / std::max(1.0, influence.weight - kRimParameters));
  const RimCovariance inverse_normal = normal.ldlt().solve(RimCovariance::Identity());
  // Huber (1981): with psi = w r the covariance is E[psi^2] / E[psi']^2 (sum g g^T)^-1, g the slopes.
  const auto count = static_cast<double>(pixels.x.size());
  const double gain = influence.weight / std::max(1.0, influence.slope);
  fit.covariance = inverse_normal * gain * gain * (influence.square / influence.weight) * count /
                   std::max(1.0, count - kRimParameters);
  fit.sector_pull = sector_pull(pixels, fit.p, inverse_normal);
  for (double& pull : fit.sector_pull) pull *= gain;
  return fit;
}

}  // namespace tribotrack::vision
