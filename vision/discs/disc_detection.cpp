#include "vision/discs/disc_detection.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "vision/discs/rim_fit.h"
#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr int kSearchMin = 6, kSearchMax = 13;  ///< radii tried on each level of the pyramid, px
constexpr double kMinClarity = 2;               ///< contrast over residual: less is no rim
constexpr double kClarityCap = 8;
constexpr std::size_t kFewestPixels = 30;  ///< near a rim, to fit it
constexpr double kPi = std::numbers::pi;
/// px of radius for an unevenness of one: by how much rendered discs with a highlight are measured too large,
/// whatever the noise.
constexpr double kUnevenBias = 0.02;

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

using Directions = std::vector<std::pair<double, double>>;

Directions directions(int count) {
  Directions out(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k)
    out[static_cast<std::size_t>(k)] = {std::cos(2 * kPi * k / count), std::sin(2 * kPi * k / count)};
  return out;
}

/// As many as the rim has pixels, about.
Directions rim_directions(double radius) {
  return directions(std::clamp(static_cast<int>(4 * radius), 32, 256));
}

double rim_step(const Picture& picture, const Circle& c, double half_width, const Directions::value_type& u) {
  const double in = c.radius - half_width;
  const double out = c.radius + half_width;
  return level_at(picture, c.x + in * u.first, c.y + in * u.second) -
         level_at(picture, c.x + out * u.first, c.y + out * u.second);
}

/// Steps across the circle, inside minus outside.
std::vector<double> rim_steps(const Picture& picture, const Circle& c, double half_width,
                              const Directions& around) {
  std::vector<double> steps;
  steps.reserve(around.size());
  for (const auto& u : around) steps.push_back(rim_step(picture, c, half_width, u));
  return steps;
}

/// Share of angles at which the step has the common sign and at least half the median size.
double coverage_of(const std::vector<double>& steps, double usual) {
  const auto seen = std::count_if(steps.begin(), steps.end(), [&](double s) { return s / usual > 0.4; });
  return static_cast<double>(seen) / static_cast<double>(steps.size());
}

/// Moves the circle uphill in the sum of steps across it; each step is capped so that a few strong edges (a
/// lamp, a neighbour) cannot outvote the rim.
Circle climb_rim(const Picture& picture, Circle c, double capture, double polarity) {
  const Directions around = rim_directions(c.radius);
  double cap = 1e9;
  const auto merit = [&](const Circle& t) {
    if (t.radius < 2) return -1e9;
    double sum = 0;
    for (const auto& u : around) sum += std::clamp(polarity * rim_step(picture, t, 1.25, u), -cap, cap);
    return sum;
  };
  {
    std::vector<double> sizes;
    for (double dr = -capture; dr <= capture; dr += 1)
      for (const double s : rim_steps(picture, {c.x, c.y, c.radius + dr}, 1.25, around))
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

/// Variance of the sum of pulls that are alike all round, from how they differ from sector to sector: the
/// power of their harmonics is that of the sum, were they white. A streaked ground pulls sectors alike over a
/// good part of the rim: then the power of the slowest harmonics, the nearest to the sum, is larger and
/// counts. The first one is taken up by the circle's centre.
double scatter_of_sum(const std::vector<double>& pull) {
  constexpr int first = 2, slow = 4;
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
  return std::max(2 * power / degrees, power_of_slow / (slow - first + 1));
}

/// Nothing where the fit has walked away from the guess or the rim does not support it.
std::optional<DiscFit> judged(const Picture& picture, RimFit fit, const Circle& guess, double capture) {
  const RimParameters& p = fit.p;
  DiscFit result;
  result.circle = {p(0), p(1), p(2)};
  const double limit = std::max(2.0, 1.5 * capture);
  if (std::hypot(p(0) - guess.x, p(1) - guess.y) > limit || std::abs(p(2) - guess.radius) > limit)
    return std::nullopt;
  std::ranges::copy(p, result.rim.begin());
  result.blur = p(3);
  // Means along the rim.
  result.contrast =
      p(kRimInside) + 0.5 * (p(kRimInside + 3) + p(kRimInside + 5)) - p(kRimOutside) - p(kRimOutside + 3);
  result.unevenness = p.segment<3>(kRimInside + 3).norm() / std::max(1e-9, std::abs(result.contrast));
  result.sector_pull = std::move(fit.sector_pull);
  result.white_radius_sd = std::sqrt(std::max(0.0, fit.covariance(2, 2)));
  result.radius_sd = mean_radius({&result, 1}).sd;
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
  const Circle rough = climb_rim(picture, guess, capture, strongest > 0 ? 1 : -1);

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
    fit = fit_rim(pixels, p, round == 1 && rim_curves(p));
    p = fit.p;
    if (!p.allFinite() || walked_away(p, guess, capture)) return std::nullopt;
    band = rim_band(p);
  }
  return judged(picture, std::move(fit), guess, capture);
}

std::optional<DiscFit> refit_disc(const Picture& picture, const DiscFit& before, Point centre,
                                  double capture) {
  RimParameters p = Eigen::Map<const RimParameters>(before.rim.data());
  p.head<2>() << centre.x, centre.y;
  const Circle guess{centre.x, centre.y, p(2)};
  auto pixels = rim_pixels(picture, guess, rim_band(p));
  if (pixels.x.size() < kFewestPixels) return std::nullopt;
  // So near, Gauss and Newton's steps leave far less than they are long.
  RimFit fit = fit_rim(pixels, p, rim_curves(p),
                       {.damping = 1e-6, .on_the_way = 2e-2, .tolerance = 1e-3, .from_near = true});
  if (!fit.p.allFinite()) return std::nullopt;
  return judged(picture, std::move(fit), guess, capture);
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
  const Directions quick = directions(64);
  for (Candidate& c : candidates) {
    // Quick look at full size: does the picture step across this circle nearly all the way round?
    const double half = std::clamp(0.12 * c.circle.radius, 1.5, 12.0);
    auto steps = rim_steps(picture, c.circle, half, quick);
    const double usual = median(steps);
    const double coverage = usual != 0 ? coverage_of(steps, usual) : 0;
    c.votes = coverage < 0.4 ? 0 : coverage * coverage * std::abs(usual) * std::sqrt(c.circle.radius);
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
