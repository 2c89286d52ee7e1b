#include "vision/discs/disc_detection.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/discs/rim_fit.h"
#include "vision/discs/rim_steps.h"
#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr double kMinClarity = 2;  ///< contrast over residual: less is no rim
constexpr double kClarityCap = 8;
constexpr std::size_t kFewestPixels = 30;  ///< near a rim, to fit it
constexpr double kPi = std::numbers::pi;
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
  result.centre_sd = std::sqrt(std::max(0.0, 0.5 * (fit.covariance(0, 0) + fit.covariance(1, 1))));
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
    fit = fit_rim(pixels, p, round == 1 && rim_curves(p, use));
    p = fit.p;
    if (!p.allFinite() || walked_away(p, guess, capture)) return std::nullopt;
    band = rim_band(p, rim_curves(p, use));
  }
  return judged(picture, fit, guess, capture);
}

namespace {

constexpr double kSeenAsWell = 0.5;  ///< of the score
constexpr double kSameSize = 0.9, kSameContrast = 0.67, kSeen = 0.2;
constexpr double kAboutAsLarge = 0.67;

double ratio(double a, double b) {
  const double low = std::min(a, b), high = std::max(a, b);
  return low > 0 ? low / high : (high < 0 ? high / low : 0);
}

double distance(const Circle& a, const Circle& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

}  // namespace

bool alike(const DiscFit& other, const DiscFit& part) {
  const double size = ratio(other.circle.radius, part.circle.radius);
  if (size > kAsLarge && other.score > kSeenAsWell * part.score) return true;
  return size > kSameSize && ratio(other.contrast, part.contrast) > kSameContrast &&
         other.score > kSeen * part.score;
}

std::vector<Circle> discs_alike(std::span<const DiscFit> found, const DiscFit& part) {
  std::vector<Circle> out{part.circle};
  for (const DiscFit& other : found)
    if (alike(other, part) && std::ranges::none_of(out, [&](const Circle& c) {
          return distance(c, other.circle) < std::max(c.radius, other.circle.radius);
        }))
      out.push_back(other.circle);
  std::ranges::sort(out, {}, &Circle::x);
  return out;
}

const DiscFit* nearest_like(std::span<const DiscFit> found, const Circle& given) {
  const DiscFit* best = nullptr;
  for (const DiscFit& f : found)
    if (ratio(f.circle.radius, given.radius) > kAboutAsLarge &&
        (!best || distance(f.circle, given) < distance(best->circle, given)))
      best = &f;
  return best;
}

}  // namespace tribotrack::vision
