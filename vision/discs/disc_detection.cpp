#include "vision/discs/disc_detection.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "vision/discs/rim_steps.h"
#include "vision/io/levels.h"
#include "vision/kernels/median.h"
#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kSectors = 36;  ///< of the rim

/// x, y, R, s, then the level inside as a quadratic in (u, v) = ((x, y) - centre) / R: 1, u, v, u^2, uv, v^2,
/// and outside as 1, u, v, u^2 + v^2. A highlight's slope towards the rim would else be taken for a part of
/// the rim; a slope on one side only would take up what the edge's profile differs from a Gaussian's.
constexpr int kRimParameters = 14;
constexpr int kRimInside = 4, kRimOutside = 10;
using RimParameters = Eigen::Matrix<double, kRimParameters, 1>;
using RimCovariance = Eigen::Matrix<double, kRimParameters, kRimParameters>;

struct RimPixels {
  std::vector<double> x, y, level, weight;
};

struct RimFit {
  RimParameters p = RimParameters::Zero();
  RimCovariance covariance = RimCovariance::Zero();
  double residual_rms = 0;
  /// What the residuals in each sector of the rim (about 5 px long) pulled the radius by, px; empty for small
  /// discs.
  std::vector<double> sector_pull;
};

constexpr std::array<int, 4> kCurved = {7, 8, 9, 13};  ///< that only large discs have
constexpr double kCurvedRadius = 12;     ///< px; smaller discs have too few pixels inside their rim
constexpr double kCurvedMeanRadius = 7;  ///< px; likewise for the mean radius
constexpr double kSectorRadius = 5;      ///< px; smaller rims have too few pixels for sectors
constexpr int kRounds = 4;               ///< of weights, the first all alike
constexpr double kOnTheWay = 1e-3, kTolerance = 1e-5;  ///< px: the last step of a round, of the last one
constexpr int kSteps = 25;                             ///< for given weights, at most
constexpr double kStays = 1.5, kWidens = 2;            ///< blurs that a wider band moves an edge by, at most
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

/// Those within `band` px of the circle, with weight 1.
RimPixels rim_pixels(const Picture& picture, const Circle& c, double band) {
  RimPixels pixels;
  const double least = std::max(0.0, c.radius - band), most = c.radius + band;
  const Rect about = window_about({c.x, c.y}, most, bounds_of(picture));
  for (int y = about.y; y < about.y + about.height; ++y)
    for (int x = about.x; x < about.x + about.width; ++x) {
      const double square = (x - c.x) * (x - c.x) + (y - c.y) * (y - c.y);
      if (square < least * least || square > most * most) continue;
      pixels.x.push_back(x);
      pixels.y.push_back(y);
      pixels.level.push_back(static_cast<double>(picture.at(x, y)));
    }
  pixels.weight.assign(pixels.x.size(), 1);
  return pixels;
}

/// Whether the disc is large enough for the curvature of its levels to be fitted. It makes the fit of a small
/// disc noisier; the mean over many frames bears that, and without curvature would be off in all of them
/// alike.
bool rim_curves(const RimParameters& p, RimUse use) {
  return p(2) >= (use == RimUse::place ? kCurvedRadius : kCurvedMeanRadius);
}

/// The band that holds the blurred edge and enough of either side, px.
double rim_band(const RimParameters& p, bool curved) {
  const double band = std::min(std::clamp(4.5 * p(3), 4.0, 30.0), 0.6 * p(2));
  // The slope of a level that may curve must be fixed by pixels.
  return curved ? std::max(band, std::min(std::clamp(6.5 * p(3), 5.5, 30.0), 0.35 * p(2))) : band;
}

/// Levenberg-Marquardt, first all pixels alike, then with Tukey's weights. Changes the pixels' weights.
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

constexpr double kMinClarity = 2;  ///< contrast over residual: less is no rim
constexpr double kClarityCap = 8;
constexpr std::size_t kFewestPixels = 30;  ///< near a rim, to fit it
/// px of radius for an unevenness of one: by how much rendered discs with a highlight are measured too large,
/// whatever the noise.
constexpr double kUnevenBias = 0.02;
/// Power of the slow harmonics over that of all from which on they are not white: once in twenty by chance.
constexpr double kClearlySlow = 2.2;

/// Larger is better, and so is a rim that stands out from what else there is, up to a point: a small mark of
/// high contrast must not outvote the part.
double score_of(double coverage, double clarity, double radius) {
  return std::pow(coverage, 4) * std::min(clarity, kClarityCap) * radius;
}

/// Variance of the sum of pulls that are alike all round, from how they differ from sector to sector: the
/// power of their harmonics is that of the sum, were they white. A streaked ground pulls sectors alike over a
/// good part of the rim: then the power of the slowest harmonics, the nearest to the sum, is larger and
/// counts. The first one is taken up by the circle's centre, and from the fourth on streaks that lie along
/// the rim average out. Where it is that of few numbers that counts, their own uncertainty widens the
/// scatter: the variance of Student's t with as many degrees of freedom.
double scatter_of_sum(const std::vector<double>& pull) {
  constexpr int first = 2, slow = 3;
  const auto count = static_cast<double>(pull.size());
  const int last = static_cast<int>(pull.size()) / 2;
  double power_of_slow = 0, power = 0;
  for (int m = first; m <= last; ++m) {
    double c = 0, s = 0;
    for (std::size_t k = 0; k < pull.size(); ++k) {
      const double angle = 2 * kPi * m * static_cast<double>(k) / count;
      c += pull[k] * std::cos(angle);
      s += pull[k] * std::sin(angle);
    }
    power += (c * c + s * s) * (2 * m == static_cast<int>(pull.size()) ? 0.5 : 1);  // no sine there
    if (m <= slow) power_of_slow += c * c + s * s;
  }
  // White pulls of variance v: c^2 + s^2 is count v on average, the variance of their sum.
  const double degrees = count - 1 - 2 * (first - 1);
  const double all = 2 * power / degrees, of_slow = power_of_slow / (slow - first + 1);
  constexpr double slow_degrees = 2 * (slow - first + 1), students = slow_degrees / (slow_degrees - 2);
  return of_slow > kClearlySlow * all ? students * of_slow : all;
}

/// Nothing where the fit has walked away from the guess or the rim does not support it.
std::optional<DiscFit> judged(const Picture& picture, const RimFit& fit, const Circle& guess,
                              double capture) {
  const RimParameters& p = fit.p;
  DiscFit result;
  result.circle = {p(0), p(1), p(2)};
  const double limit = fit_reach(capture);
  if (std::hypot(p(0) - guess.x, p(1) - guess.y) > limit || std::abs(p(2) - guess.radius) > limit)
    return std::nullopt;
  result.blur = p(3);
  // Means along the rim.
  result.outside = p(kRimOutside) + p(kRimOutside + 3);
  result.contrast = p(kRimInside) + 0.5 * (p(kRimInside + 3) + p(kRimInside + 5)) - result.outside;
  result.common_sd =
      kUnevenBias * p.segment<3>(kRimInside + 3).norm() / std::max(1e-9, std::abs(result.contrast));
  const double scatter = fit.sector_pull.empty() ? 0 : scatter_of_sum(fit.sector_pull);
  result.radius_sd =
      std::sqrt(std::max({0.0, fit.covariance(2, 2), scatter}) + result.common_sd * result.common_sd);
  result.residual_rms = fit.residual_rms;
  const double half = std::min(std::max(1.5, 2 * p(3)), 0.5 * p(2));
  result.coverage =
      coverage_of(rim_steps(picture, result.circle, half, rim_directions(guess.radius)), result.contrast);
  const double clarity = std::abs(result.contrast) / std::max(0.3, result.residual_rms);
  result.score = score_of(result.coverage, clarity, p(2));
  if (result.coverage < 0.5 || clarity < kMinClarity || result.radius_sd > 0.1 * p(2)) return std::nullopt;
  return result;
}

/// Where pixels do not support a rim its parameters go anywhere; far from the guess nothing is left to fit.
bool walked_away(const RimParameters& p, const Circle& guess, double capture) {
  const double far = 5 * capture + guess.radius;
  return std::hypot(p(0) - guess.x, p(1) - guess.y) > far || std::abs(p(2) - guess.radius) > far;
}

/// Of the circle, px.
double moved(const RimParameters& to, const RimParameters& from) {
  return (to - from).head<3>().cwiseAbs().maxCoeff();
}

}  // namespace

double largest_score(double radius) {
  return score_of(1, kClarityCap, radius);
}

double fit_reach(double capture) {
  return std::max(2.0, 1.5 * capture);
}

std::optional<DiscFit> fit_disc(const Picture& picture, const Circle& guess, double capture, RimUse use) {
  const Directions around = rim_directions(guess.radius);
  // Which way round: the median step over the captured radii that is largest in size.
  double strongest = 0;
  for (double dr = -capture; dr <= capture; dr += 0.5) {
    const double r = guess.radius + dr;
    if (r < 2) continue;
    const double step = median(rim_steps(picture, {guess.x, guess.y, r}, 1.5, around));
    if (std::abs(step) > std::abs(strongest)) strongest = step;
  }
  if (strongest == 0) return std::nullopt;
  const Circle rough = climb_rim(picture, guess, capture, strongest > 0 ? 1 : -1, around);

  const auto level_along = [&](double radius) {
    std::vector<double> levels;
    for (const auto& [ux, uy] : around)
      levels.push_back(level_at(picture, rough.x + radius * ux, rough.y + radius * uy));
    return median(levels);
  };
  RimParameters p = RimParameters::Zero();
  p.head<4>() << rough.x, rough.y, rough.radius, 1.0;
  p(kRimInside) = level_along(rough.radius - 2.5);
  p(kRimOutside) = level_along(rough.radius + 2.5);
  RimFit fit;
  // The band must hold the blurred edge and a little of either side: a second round knows the blur.
  double band = std::min(4.0, 0.6 * rough.radius);
  for (int round = 0; round < 2; ++round) {
    auto pixels = rim_pixels(picture, {p(0), p(1), p(2)}, band);
    if (pixels.x.size() < kFewestPixels) return std::nullopt;
    RimFit next = fit_rim(pixels, p, round == 1 && rim_curves(p, use));
    const bool finite = next.p.allFinite();
    // A chamfer's ring beside the edge looks like levels that slope steeply and a wider edge somewhere else.
    if (round == 1 && (!finite || next.p(3) > kWidens * p(3) ||
                       (next.p(3) > p(3) && moved(next.p, p) > kStays * std::max(1.0, p(3)))))
      break;
    fit = std::move(next);
    p = fit.p;
    if (!finite || walked_away(p, guess, capture)) return std::nullopt;
    band = rim_band(p, rim_curves(p, use));
  }
  return judged(picture, fit, guess, capture);
}

}  // namespace tribotrack::vision
