#include "vision/disc_detection.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace tribotrack::vision {
namespace {

constexpr int kSearchMin = 6, kSearchMax = 13;  ///< radii tried on each level of the pyramid, px
constexpr double kMinClarity = 2;               ///< contrast over residual: less is no rim
constexpr double kClarityCap = 8;
constexpr double kPi = std::numbers::pi;
constexpr std::size_t kSectors = 36;  ///< of the rim
/// px of radius for an unevenness of one: by how much rendered discs with a highlight are measured too large
/// or too small, whatever the noise.
constexpr double kUnevenBias = 0.015;
constexpr double kSectorRadius = 20;  ///< px; smaller rims have too few pixels for them

double level_at(const Picture& picture, double x, double y) {
  x = std::clamp(x, 0.0, picture.width() - 1.001);
  y = std::clamp(y, 0.0, picture.height() - 1.001);
  const int ix = static_cast<int>(x);
  const int iy = static_cast<int>(y);
  const double fx = x - ix;
  const double fy = y - iy;
  return (1 - fy) * ((1 - fx) * picture.at(ix, iy) + fx * picture.at(ix + 1, iy)) +
         fy * ((1 - fx) * picture.at(ix, iy + 1) + fx * picture.at(ix + 1, iy + 1));
}

/// Steps across the circle, inside minus outside, at `count` angles.
std::vector<double> rim_steps(const Picture& picture, const Circle& c, double half_width, int count) {
  std::vector<double> steps(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    const double ux = std::cos(2 * kPi * k / count);
    const double uy = std::sin(2 * kPi * k / count);
    const double in = c.radius - half_width;
    const double out = c.radius + half_width;
    steps[static_cast<std::size_t>(k)] =
        level_at(picture, c.x + in * ux, c.y + in * uy) - level_at(picture, c.x + out * ux, c.y + out * uy);
  }
  return steps;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Share of angles at which the step has the common sign and at least half the median size.
double coverage_of(const std::vector<double>& steps, double median) {
  const auto seen = std::count_if(steps.begin(), steps.end(), [&](double s) { return s / median > 0.4; });
  return static_cast<double>(seen) / static_cast<double>(steps.size());
}

/// Moves the circle uphill in the sum of steps across it; each step is capped so that a few strong edges (a
/// lamp, a neighbour) cannot outvote the rim.
Circle climb_rim(const Picture& picture, Circle c, double capture, double polarity) {
  const int count = std::clamp(static_cast<int>(4 * c.radius), 32, 256);
  double cap = 1e9;
  const auto merit = [&](const Circle& t) {
    if (t.radius < 2) return -1e9;
    double sum = 0;
    for (const double s : rim_steps(picture, t, 1.25, count)) sum += std::clamp(polarity * s, -cap, cap);
    return sum;
  };
  {
    std::vector<double> sizes;
    for (double dr = -capture; dr <= capture; dr += 1)
      for (const double s : rim_steps(picture, {c.x, c.y, c.radius + dr}, 1.25, count))
        sizes.push_back(std::abs(s));
    std::sort(sizes.begin(), sizes.end());
    cap = std::max(1e-3, sizes[sizes.size() * 9 / 10]);
  }
  double best = merit(c);
  for (double step = std::max(0.5, capture / 2); step > 0.2;) {
    Circle better = c;
    for (int k = 0; k < 27; ++k) {
      const Circle t{c.x + (k % 3 - 1) * step, c.y + (k / 3 % 3 - 1) * step, c.radius + (k / 9 - 1) * step};
      const double m = merit(t);
      if (m > best) {
        best = m;
        better = t;
      }
    }
    if (better.x == c.x && better.y == c.y && better.radius == c.radius) step /= 2;
    c = better;
  }
  return c;
}

double normal_cdf(double t) {
  return 0.5 * std::erfc(-t / std::numbers::sqrt2);
}

/// x, y, R, s, then the level inside as a quadratic in (u, v) = (x, y) / R: 1, u, v, u^2, uv, v^2, and
/// outside as 1, u, v, u^2 + v^2. A highlight's slope towards the rim would else be taken for a part of the
/// rim; a slope on one side only would take up what the edge's profile differs from a Gaussian's.
constexpr int kParameters = 14;
constexpr std::array<int, 4> kCurved = {7, 8, 9, 13};  ///< that only large discs have
constexpr int kOutside = 10;
constexpr double kCurvedRadius = 12;  ///< px; smaller discs have too few pixels inside their rim
using Parameters = Eigen::Matrix<double, kParameters, 1>;
using Covariance = Eigen::Matrix<double, kParameters, kParameters>;

struct RimPixel {
  double x, y, level, weight;
};

/// Model and its derivatives at one pixel.
double rim_model(const Parameters& p, double x, double y, Parameters& slope) {
  const double dx = x - p(0);
  const double dy = y - p(1);
  const double rho = std::max(1e-9, std::hypot(dx, dy));
  const double r = p(2);
  const double s = p(3);
  const double t = (r - s * s / (2 * r) - rho) / s;
  const double inside = normal_cdf(t);
  const double density = std::exp(-0.5 * t * t) / std::sqrt(2 * kPi);
  const double u = dx / r;
  const double v = dy / r;
  const double level_in = p(4) + p(5) * u + p(6) * v + p(7) * u * u + p(8) * u * v + p(9) * v * v;
  const double level_out = p(10) + p(11) * u + p(12) * v + p(13) * (u * u + v * v);
  const double rise = (level_in - level_out) * density;
  slope << rise * dx / (rho * s), rise * dy / (rho * s), rise * (1 / s + s / (2 * r * r)),
      rise * (-t / s - 1 / r), inside, inside * u, inside * v, inside * u * u, inside * u * v, inside * v * v,
      1 - inside, (1 - inside) * u, (1 - inside) * v, (1 - inside) * (u * u + v * v);
  return level_out + (level_in - level_out) * inside;
}

std::vector<RimPixel> rim_pixels(const Picture& picture, const Circle& c, double band) {
  std::vector<RimPixel> pixels;
  const double reach = c.radius + band;
  const int x0 = std::max(0, static_cast<int>(std::floor(c.x - reach)));
  const int x1 = std::min(picture.width() - 1, static_cast<int>(std::ceil(c.x + reach)));
  const int y0 = std::max(0, static_cast<int>(std::floor(c.y - reach)));
  const int y1 = std::min(picture.height() - 1, static_cast<int>(std::ceil(c.y + reach)));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x)
      if (std::abs(std::hypot(x - c.x, y - c.y) - c.radius) <= band)
        pixels.push_back({static_cast<double>(x), static_cast<double>(y), picture.at(x, y), 1});
  return pixels;
}

struct RimFit {
  Parameters p = Parameters::Zero();
  Covariance covariance = Covariance::Zero();
  double residual_rms = 0;
  std::vector<double> sector_pull;  ///< see DiscFit
};

/// What the residuals of each sector of the rim do to the radius: -(N^-1 sum w g r)_R.
std::vector<double> sector_pull(const std::vector<RimPixel>& pixels, const RimFit& fit,
                                const Covariance& inverse_normal) {
  if (fit.p(2) < kSectorRadius) return {};
  std::vector<double> pull(kSectors, 0);
  Parameters slope;
  for (const RimPixel& q : pixels) {
    const double r = q.level - rim_model(fit.p, q.x, q.y, slope);
    const double turn = 0.5 + std::atan2(q.y - fit.p(1), q.x - fit.p(0)) / (2 * kPi);
    const auto sector = std::min(static_cast<std::size_t>(turn * kSectors), kSectors - 1);
    pull[sector] += q.weight * r * inverse_normal.row(2).dot(slope);
  }
  return pull;
}

/// Levenberg-Marquardt with Tukey's weights.
RimFit fit_rim(std::vector<RimPixel>& pixels, const Parameters& start, bool curved) {
  RimFit fit;
  fit.p = start;
  Parameters slope;
  const auto weighted_cost = [&](const Parameters& p) {
    double cost = 0;
    for (const RimPixel& q : pixels) {
      const double r = q.level - rim_model(p, q.x, q.y, slope);
      cost += q.weight * r * r;
    }
    return cost;
  };
  double damping = 1e-3;
  Covariance normal;
  struct {
    double weight = 0, square = 0, slope = 0;  // sums of w, psi^2, psi'
  } influence;
  for (int round = 0; round < 4; ++round) {
    double cost = weighted_cost(fit.p);
    for (int k = 0; k < 25; ++k) {
      normal.setZero();
      Parameters gradient = Parameters::Zero();
      for (const RimPixel& q : pixels) {
        if (q.weight <= 0) continue;
        const double r = q.level - rim_model(fit.p, q.x, q.y, slope);
        normal.selfadjointView<Eigen::Lower>().rankUpdate(slope, q.weight);
        gradient += q.weight * r * slope;
      }
      normal = Covariance(normal.selfadjointView<Eigen::Lower>());
      if (!curved)
        for (const int i : kCurved) {
          normal.row(i).setZero();
          normal.col(i).setZero();
          normal(i, i) = 1;
          gradient(i) = 0;
        }
      bool improved = false;
      double moved = 0;
      for (int tries = 0; tries < 8 && !improved; ++tries) {
        Covariance damped = normal;
        damped.diagonal() *= 1 + damping;
        const Parameters step = damped.ldlt().solve(gradient);
        Parameters trial = fit.p + step;
        trial(3) = std::clamp(trial(3), 0.3, 0.5 * std::max(1.0, trial(2)));
        const double trial_cost = trial(2) > 1 ? weighted_cost(trial) : 1e300;
        if (trial_cost <= cost) {
          moved = std::max({std::abs(step(0)), std::abs(step(1)), std::abs(step(2)), std::abs(step(3))});
          fit.p = trial;
          cost = trial_cost;
          damping = std::max(1e-9, damping / 10);
          improved = true;
        } else {
          damping *= 10;
        }
      }
      if (!improved || moved < 1e-5) break;
    }
    std::vector<double> sizes;
    sizes.reserve(pixels.size());
    for (const RimPixel& q : pixels) sizes.push_back(std::abs(q.level - rim_model(fit.p, q.x, q.y, slope)));
    const double scale = std::max(0.3, 1.4826 * median_of(sizes));
    double weight = 0;
    double squares = 0;
    influence = {};
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const double t = sizes[i] / (6 * scale);
      pixels[i].weight = t < 1 ? (1 - t * t) * (1 - t * t) : 0;
      weight += pixels[i].weight;
      squares += pixels[i].weight * sizes[i] * sizes[i];
      influence.square += std::pow(pixels[i].weight * sizes[i], 2);
      influence.slope += t < 1 ? (1 - t * t) * (1 - 5 * t * t) : 0;
    }
    influence.weight = weight;
    fit.residual_rms = std::sqrt(squares / std::max(1.0, weight - kParameters));
  }
  const Covariance inverse_normal = normal.ldlt().solve(Covariance::Identity());
  // Huber (1981): with psi = w r the covariance is E[psi^2] / E[psi']^2 (sum g g^T)^-1, g the slopes.
  const auto count = static_cast<double>(pixels.size());
  const double gain = influence.weight / std::max(1.0, influence.slope);
  fit.covariance = inverse_normal * gain * gain * (influence.square / influence.weight) * count /
                   std::max(1.0, count - kParameters);
  fit.sector_pull = sector_pull(pixels, fit, inverse_normal);
  for (double& pull : fit.sector_pull) pull *= gain;
  return fit;
}

/// Larger is better, and so is a rim that stands out from what else there is, up to a point: a small mark of
/// high contrast must not outvote the part.
double score_of(double coverage, double clarity, double radius) {
  return std::pow(coverage, 4) * std::min(clarity, kClarityCap) * radius;
}

struct Candidate {
  Circle circle;
  double votes = 0;
};

/// Circles of kSearchMin .. kSearchMax px on one level of the pyramid, in its pixels.
void vote(const cv::Mat& level, double scale, std::vector<Candidate>& out) {
  cv::Mat smooth, gx, gy, size;
  cv::GaussianBlur(level, smooth, {}, 0.8);
  cv::Sobel(smooth, gx, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(smooth, gy, CV_32F, 0, 1, 3, 0.125);
  cv::magnitude(gx, gy, size);
  std::vector<float> sorted(size.begin<float>(), size.end<float>());
  const auto rank = static_cast<std::ptrdiff_t>(0.85 * static_cast<double>(sorted.size()));
  std::nth_element(sorted.begin(), sorted.begin() + rank, sorted.end());
  const float threshold = std::max(0.5F, sorted[static_cast<std::size_t>(rank)]);
  struct Edge {
    float x, y, ux, uy;
  };
  std::vector<Edge> edges;
  for (int y = 0; y < level.rows; ++y)
    for (int x = 0; x < level.cols; ++x) {
      const float g = size.at<float>(y, x);
      if (g >= threshold)
        edges.push_back(
            {static_cast<float>(x), static_cast<float>(y), gx.at<float>(y, x) / g, gy.at<float>(y, x) / g});
    }
  cv::Mat votes(level.size(), CV_32F);
  cv::Mat gathered;
  for (const float sign : {1.0F, -1.0F})
    for (int r = kSearchMin; r <= kSearchMax; ++r) {
      votes.setTo(0);
      for (const Edge& e : edges) {
        const int x = static_cast<int>(std::lround(e.x + sign * static_cast<float>(r) * e.ux));
        const int y = static_cast<int>(std::lround(e.y + sign * static_cast<float>(r) * e.uy));
        if (x >= 0 && y >= 0 && x < level.cols && y < level.rows) votes.at<float>(y, x) += 1;
      }
      cv::boxFilter(votes, gathered, CV_32F, {3, 3}, {-1, -1}, false, cv::BORDER_CONSTANT);
      for (int k = 0; k < 6; ++k) {
        double top = 0;
        cv::Point place;
        cv::minMaxLoc(gathered, nullptr, &top, nullptr, &place);
        if (top < 0.35 * 2 * kPi * r) break;
        cv::circle(gathered, place, r / 2, cv::Scalar(0), cv::FILLED);
        // Pixel centres at integers: averaging blocks shifts them by half a block.
        out.push_back(
            {{(place.x + 0.5) * scale - 0.5, (place.y + 0.5) * scale - 0.5, r * scale}, top / (2 * kPi * r)});
      }
    }
}

bool whole(const Picture& picture, const Circle& c) {
  return c.x - c.radius >= 0 && c.y - c.radius >= 0 && c.x + c.radius <= picture.width() - 1 &&
         c.y + c.radius <= picture.height() - 1;
}

/// Variance of the sum of pulls that are alike all round, told by how they differ from sector to sector: the
/// power of their harmonics is that of the sum, were they white. A streaked ground pulls sectors alike over a
/// good part of the rim: then the power of the slowest harmonics, the nearest to the sum, is larger and
/// counts. The first one is taken up by the circle's centre.
double scatter_of_sum(const std::vector<double>& pull) {
  constexpr int first = 2, slow = 4;
  const auto count = static_cast<double>(pull.size());
  const int last = static_cast<int>(pull.size()) / 2 - 1;
  double power_of_slow = 0, power = 0;
  for (int m = first; m <= last; ++m) {
    double c = 0, s = 0;
    for (std::size_t k = 0; k < pull.size(); ++k) {
      const double angle = 2 * kPi * m * static_cast<double>(k) / count;
      c += pull[k] * std::cos(angle);
      s += pull[k] * std::sin(angle);
    }
    power += c * c + s * s;
    if (m <= slow) power_of_slow += c * c + s * s;
  }
  // White pulls of variance v: c^2 + s^2 is count v, the variance of their sum.
  return std::max(power / (last - first + 1), power_of_slow / (slow - first + 1));
}

}  // namespace

MeanRadius mean_radius(std::span<const DiscFit> fits) {
  MeanRadius mean;
  const auto count = static_cast<double>(fits.size());
  std::vector<double> pull(kSectors, 0);
  double white = 0;
  bool sectors = true;
  for (const DiscFit& fit : fits) {
    mean.radius += fit.circle.radius / count;
    white += std::pow(fit.white_radius_sd / count, 2);
    mean.common_sd += kUnevenBias * fit.unevenness / count;
    sectors = sectors && fit.sector_pull.size() == kSectors;
  }
  mean.sd = std::hypot(std::sqrt(white), mean.common_sd);
  if (!sectors) return mean;
  for (const DiscFit& fit : fits)
    for (std::size_t k = 0; k < kSectors; ++k) pull[k] += fit.sector_pull[k] / count;
  mean.sd = std::hypot(std::sqrt(std::max(white, scatter_of_sum(pull))), mean.common_sd);
  return mean;
}

std::optional<DiscFit> fit_disc(const Picture& picture, const Circle& guess, double capture) {
  const int count = std::clamp(static_cast<int>(4 * guess.radius), 32, 256);
  // Which way round: the median step over the captured radii that is largest in size.
  double strongest = 0;
  for (double dr = -capture; dr <= capture; dr += 0.5) {
    const double r = guess.radius + dr;
    if (r < 2) continue;
    const double median = median_of(rim_steps(picture, {guess.x, guess.y, r}, 1.5, count));
    if (std::abs(median) > std::abs(strongest)) strongest = median;
  }
  if (strongest == 0) return std::nullopt;
  const Circle rough = climb_rim(picture, guess, capture, strongest > 0 ? 1 : -1);

  Parameters p;
  const double in = median_of([&] {
    std::vector<double> v;
    for (int k = 0; k < count; ++k)
      v.push_back(level_at(picture, rough.x + (rough.radius - 2.5) * std::cos(2 * kPi * k / count),
                           rough.y + (rough.radius - 2.5) * std::sin(2 * kPi * k / count)));
    return v;
  }());
  const double out = median_of([&] {
    std::vector<double> v;
    for (int k = 0; k < count; ++k)
      v.push_back(level_at(picture, rough.x + (rough.radius + 2.5) * std::cos(2 * kPi * k / count),
                           rough.y + (rough.radius + 2.5) * std::sin(2 * kPi * k / count)));
    return v;
  }());
  p << rough.x, rough.y, rough.radius, 1.0, in, 0, 0, 0, 0, 0, out, 0, 0, 0;
  RimFit fit;
  // The band must hold the blurred edge and a little of either side: a second round knows the blur.
  double band = std::min(4.0, 0.6 * rough.radius);
  for (int round = 0; round < 2; ++round) {
    auto pixels = rim_pixels(picture, {p(0), p(1), p(2)}, band);
    if (pixels.size() < 30) return std::nullopt;
    fit = fit_rim(pixels, p, round == 1 && p(2) >= kCurvedRadius);
    p = fit.p;
    if (!p.allFinite()) return std::nullopt;
    band = std::min(std::clamp(4.5 * p(3), 4.0, 30.0), 0.6 * p(2));
    // A level that may curve needs pixels to tell its slope by.
    if (p(2) >= kCurvedRadius)
      band = std::max(band, std::min(std::clamp(6.5 * p(3), 5.5, 30.0), 0.35 * p(2)));
  }
  DiscFit result;
  result.circle = {p(0), p(1), p(2)};
  const double limit = std::max(2.0, 1.5 * capture);
  if (std::hypot(p(0) - guess.x, p(1) - guess.y) > limit || std::abs(p(2) - guess.radius) > limit)
    return std::nullopt;
  result.blur = p(3);
  result.contrast = p(4) + 0.5 * (p(7) + p(9)) - p(kOutside) - p(kOutside + 3);  // means along the rim
  result.unevenness =
      std::sqrt(p(7) * p(7) + p(8) * p(8) + p(9) * p(9)) / std::max(1e-9, std::abs(result.contrast));
  result.sector_pull = std::move(fit.sector_pull);
  result.white_radius_sd = std::sqrt(std::max(0.0, fit.covariance(2, 2)));
  result.radius_sd = mean_radius({&result, 1}).sd;
  result.centre_sd = std::sqrt(std::max(0.0, 0.5 * (fit.covariance(0, 0) + fit.covariance(1, 1))));
  result.residual_rms = fit.residual_rms;
  const double half = std::min(std::max(1.5, 2 * p(3)), 0.5 * p(2));
  result.coverage = coverage_of(rim_steps(picture, result.circle, half, count), result.contrast);
  const double clarity = std::abs(result.contrast) / std::max(0.3, result.residual_rms);
  result.score = score_of(result.coverage, clarity, p(2));
  if (result.coverage < 0.5 || clarity < kMinClarity || result.radius_sd > 0.1 * p(2)) return std::nullopt;
  return result;
}

std::vector<DiscFit> find_discs(const Picture& picture, const DiscSearch& search, int max_count) {
  const cv::Mat full(picture.height(), picture.width(), CV_32F, const_cast<float*>(picture.levels().data()));
  std::vector<Candidate> candidates;
  for (int scale = 1; scale * kSearchMin <= search.max_radius; scale *= 2) {
    const int width = picture.width() / scale;
    const int height = picture.height() / scale;
    if (std::min(width, height) < 2 * kSearchMin + 1) break;
    if (scale * kSearchMax < search.min_radius) continue;
    cv::Mat level;
    cv::resize(full(cv::Rect(0, 0, width * scale, height * scale)), level, {width, height}, 0, 0,
               cv::INTER_AREA);
    vote(level, scale, candidates);
  }
  for (Candidate& c : candidates) {
    // Quick look at full size: does the picture step across this circle nearly all the way round?
    const double half = std::clamp(0.12 * c.circle.radius, 1.5, 12.0);
    const auto steps = rim_steps(picture, c.circle, half, 64);
    const double median = median_of(steps);
    const double coverage = median != 0 ? coverage_of(steps, median) : 0;
    c.votes = coverage < 0.4 ? 0 : coverage * coverage * std::abs(median) * std::sqrt(c.circle.radius);
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.votes > b.votes; });
  std::vector<DiscFit> found;
  std::vector<Circle> tried;
  const auto same = [](const Circle& a, const Circle& b) {
    return std::hypot(a.x - b.x, a.y - b.y) < 0.3 * std::min(a.radius, b.radius) &&
           std::abs(a.radius - b.radius) < 0.15 * std::max(a.radius, b.radius);
  };
  for (const Candidate& c : candidates) {
    if (c.votes <= 0 || tried.size() > 40) break;
    const auto is_tried = [&](const Circle& t) { return same(t, c.circle); };
    if (std::count_if(tried.begin(), tried.end(), is_tried) >= 2) continue;
    tried.push_back(c.circle);
    const auto fit = fit_disc(picture, c.circle, std::max(1.5, 0.12 * c.circle.radius));
    if (!fit || fit->coverage < search.min_coverage || !whole(picture, fit->circle)) continue;
    // A soft blob is no disc, and a rim must stand out from the texture around it.
    if (fit->blur > search.max_blur_share * fit->circle.radius ||
        std::abs(fit->contrast) < search.min_clarity * fit->residual_rms)
      continue;
    if (fit->circle.radius < search.min_radius || fit->circle.radius > search.max_radius) continue;
    if (search.keep_out &&
        std::hypot(search.keep_out->x - fit->circle.x, search.keep_out->y - fit->circle.y) <
            search.keep_out->radius + fit->circle.radius)
      continue;
    const auto known = std::find_if(found.begin(), found.end(),
                                    [&](const DiscFit& f) { return same(f.circle, fit->circle); });
    if (known == found.end())
      found.push_back(*fit);
    else if (fit->score > known->score)
      *known = *fit;
  }
  std::sort(found.begin(), found.end(), [](const DiscFit& a, const DiscFit& b) { return a.score > b.score; });
  if (found.size() > static_cast<std::size_t>(max_count)) found.resize(static_cast<std::size_t>(max_count));
  return found;
}

}  // namespace tribotrack::vision
