// Discs in a picture: votes for circles on a pyramid, of which those that fit are kept.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <span>
#include <utility>

#include "vision/discs/disc_detection.h"
#include "vision/discs/rim_steps.h"
#include "vision/kernels/median.h"
#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

constexpr int kSearchMin = 6, kSearchMax = 13;  ///< radii tried on each level of the pyramid, px

/// A pixel with a strong gradient, and its direction.
struct Edge {
  float x, y, ux, uy;
};

/// The steepest pixels of a level.
std::vector<Edge> edges_of(const cv::Mat& level) {
  constexpr double weak = 0.85;             // share of the pixels that are no edges
  constexpr std::size_t looked_at = 65536;  // pixels that tell the quantile
  cv::Mat smooth, gx, gy, size;
  cv::GaussianBlur(level, smooth, {}, 0.8);
  cv::Sobel(smooth, gx, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(smooth, gy, CV_32F, 0, 1, 3, 0.125);
  cv::magnitude(gx, gy, size);
  const std::span<const float> sizes(size.ptr<float>(), size.total());
  std::vector<float> sorted;
  const std::size_t stride = 1 + sizes.size() / looked_at;
  for (std::size_t i = 0; i < sizes.size(); i += stride) sorted.push_back(sizes[i]);
  const auto rank = static_cast<std::ptrdiff_t>(weak * static_cast<double>(sorted.size()));
  std::nth_element(sorted.begin(), sorted.begin() + rank, sorted.end());
  const float threshold = std::max(0.5F, sorted[static_cast<std::size_t>(rank)]);
  std::vector<Edge> edges;
  for (int y = 0; y < level.rows; ++y) {
    const float *g = size.ptr<float>(y), *x_slope = gx.ptr<float>(y), *y_slope = gy.ptr<float>(y);
    for (int x = 0; x < level.cols; ++x)
      if (g[x] >= threshold)
        edges.push_back({static_cast<float>(x), static_cast<float>(y), x_slope[x] / g[x], y_slope[x] / g[x]});
  }
  return edges;
}

/// Votes for the centre of circles of one radius, each gathered from 3 x 3 px. `radius` is negative where the
/// inside is the brighter.
cv::Mat votes_for(const std::vector<Edge>& edges, cv::Size size, float radius) {
  constexpr int kPad = kSearchMax + 1;  // votes beyond the picture need not be told from others
  cv::Mat cells = cv::Mat::zeros(size.height + 2 * kPad, size.width + 2 * kPad, CV_16U), gathered;
  for (const Edge& e : edges)
    ++cells.at<std::uint16_t>(static_cast<int>(e.y + radius * e.uy + (kPad + 0.5F)),
                              static_cast<int>(e.x + radius * e.ux + (kPad + 0.5F)));
  cv::boxFilter(cells, gathered, -1, {3, 3}, {-1, -1}, false, cv::BORDER_CONSTANT);
  return gathered({kPad, kPad, size.width, size.height});
}

/// Circles of kSearchMin .. kSearchMax px on one level of the pyramid, in the picture's pixels.
std::vector<Circle> vote(const cv::Mat& level, double scale) {
  constexpr int most = 6;         // of one radius
  constexpr double least = 0.35;  // votes over the pixels of the circle
  const std::vector<Edge> edges = edges_of(level);
  std::vector<Circle> out;
  for (const float sign : {1.0F, -1.0F})
    for (int r = kSearchMin; r <= kSearchMax; ++r) {
      cv::Mat votes = votes_for(edges, level.size(), sign * static_cast<float>(r));
      for (int k = 0; k < most; ++k) {
        double count = 0;
        cv::Point place;
        cv::minMaxLoc(votes, nullptr, &count, nullptr, &place);
        if (count < least * 2 * std::numbers::pi * r) break;
        cv::circle(votes, place, r / 2, 0, cv::FILLED);
        // Pixel centres at integers: averaging blocks shifts them by half a block.
        out.push_back({(place.x + 0.5) * scale - 0.5, (place.y + 0.5) * scale - 0.5, r * scale});
      }
    }
  return out;
}

bool whole(const Picture& picture, const Circle& c) {
  return c.x - c.radius >= 0 && c.y - c.radius >= 0 && c.x + c.radius <= picture.width() - 1 &&
         c.y + c.radius <= picture.height() - 1;
}

bool same_disc(const Circle& a, const Circle& b) {
  return distance(a, b) < 0.3 * std::min(a.radius, b.radius) &&
         std::abs(a.radius - b.radius) < 0.15 * std::max(a.radius, b.radius);
}

double capture_of(const Circle& candidate) {
  return std::max(1.5, 0.12 * candidate.radius);
}

/// No disc that is found from a circle of that radius is larger.
double largest_from(double radius) {
  return radius + fit_reach(capture_of({0, 0, radius}));
}

/// Whether discs that are no larger than `radius` are not asked for beside these.
bool unwanted_beside(const std::vector<DiscFit>& found, double radius, const DiscSearch& search) {
  if (found.empty() || !(search.beside_best > 0)) return false;
  const DiscFit& best = *std::ranges::max_element(found, {}, &DiscFit::score);
  return largest_score(radius) < best.score && radius < search.beside_best * best.circle.radius;
}

/// What a search has come across, and fitted of it.
class Finds {
 public:
  Finds(const Picture& picture, const DiscSearch& search) : picture_(picture), search_(search) {}

  /// Quick look at full size: does the picture step across this circle nearly all the way round, and by more
  /// than chance?
  void add(const Circle& c) {
    auto steps = rim_steps(picture_, c, width_of_look(c), quick_);
    const double usual = median(steps);
    const double coverage = usual != 0 ? coverage_of(steps, usual) : 0;
    if (coverage < 0.4 || clarity_of(steps, usual) < 0.5 * kLeastClarity) return;
    const double votes = coverage * coverage * std::abs(usual) * std::sqrt(c.radius);
    if (votes > 0) looks_.push_back({c, usual > 0 ? 1.0 : -1.0, votes});
  }

  /// The discs among all that was added, best first.
  std::vector<DiscFit> discs() {
    std::ranges::sort(looks_, std::greater(), &Look::votes);
    std::vector<DiscFit> found;
    std::vector<Circle> tried;
    for (Look& look : looks_) {
      if (tried.size() > kMostTried) break;
      if (unwanted_beside(found, largest_from(look.circle.radius), search_)) continue;
      if (std::ranges::count_if(tried, [&](const Circle& t) { return same_disc(t, look.circle); }) >= 2)
        continue;
      tried.push_back(look.circle);
      const auto& fit = fitted(look);
      if (!fit) continue;
      const auto known =
          std::ranges::find_if(found, [&](const DiscFit& f) { return same_disc(f.circle, fit->circle); });
      if (known == found.end())
        found.push_back(*fit);
      else if (fit->score > known->score)
        *known = *fit;
    }
    std::ranges::sort(found, std::greater(), &DiscFit::score);
    return found;
  }

 private:
  static constexpr std::size_t kMostTried = 40;
  static constexpr double kLeastClarity = 1;  ///< half of it for circles a little off
  struct Look {
    Circle circle;
    double polarity = 1;  ///< as in climb_rim
    double votes = 0;
    bool tried = false;
    std::optional<DiscFit> fit = {};
  };

  const std::optional<DiscFit>& fitted(Look& look) {
    if (!look.tried && may_fit(look)) look.fit = fit_disc(picture_, look.circle, capture_of(look.circle));
    if (look.fit && !wanted(*look.fit)) look.fit.reset();
    look.tried = true;
    return look.fit;
  }

  /// Whether the best circle nearby is seen nearly all the way round, by steps that are no chance: far
  /// cheaper than a fit, and what this turns down no fit accepts.
  bool may_fit(const Look& look) const {
    constexpr double share = 0.8;  // of the rim that must be seen in the end
    const Circle near = climb_rim(picture_, look.circle, capture_of(look.circle), look.polarity, quick_);
    return std::ranges::any_of(std::array{1.5, width_of_look(near)}, [&](double half_width) {
      auto steps = rim_steps(picture_, near, half_width, quick_);
      const double usual = median(steps);
      return usual != 0 && coverage_of(steps, usual) >= share * search_.min_coverage &&
             clarity_of(steps, usual) >= kLeastClarity;
    });
  }

  /// The usual step over the scatter of the steps, which it takes for work space.
  static double clarity_of(std::vector<double>& steps, double usual) {
    for (double& step : steps) step = std::abs(step - usual);
    return std::abs(usual) / std::max(1e-9, kNormalMad * median(steps));
  }

  static double width_of_look(const Circle& c) { return std::clamp(0.12 * c.radius, 1.5, 12.0); }

  bool wanted(const DiscFit& fit) const {
    const Circle& c = fit.circle;
    if (fit.coverage < search_.min_coverage || !whole(picture_, c)) return false;
    // A soft blob is no disc, and a rim must stand out from the texture around it.
    if (fit.blur > search_.max_blur_share * c.radius ||
        std::abs(fit.contrast) < search_.min_clarity * fit.residual_rms)
      return false;
    if (c.radius < search_.min_radius || c.radius > search_.max_radius) return false;
    const auto& out = search_.keep_out;
    return !out || distance(*out, c) >= out->radius + c.radius;
  }

  const Picture& picture_;
  const DiscSearch& search_;
  Directions quick_ = directions(64);
  std::vector<Look> looks_;
};

/// The picture and its halves, each the one before averaged over 2 x 2 pixels, as far as discs are searched.
std::vector<cv::Mat> pyramid(const Picture& picture, const DiscSearch& search) {
  cv::Mat level = matrix_of(picture);
  std::vector<cv::Mat> levels;
  for (int scale = 1; scale * kSearchMin <= search.max_radius; scale *= 2) {
    if (std::min(level.cols, level.rows) < 2 * kSearchMin + 1) break;
    levels.push_back(level);
    const cv::Size half(level.cols / 2, level.rows / 2);
    cv::Mat next;
    cv::resize(level(cv::Rect(0, 0, 2 * half.width, 2 * half.height)), next, half, 0, 0, cv::INTER_AREA);
    level = next;
  }
  return levels;
}

}  // namespace

std::vector<DiscFit> find_discs(const Picture& picture, const DiscSearch& search, int max_count) {
  const std::vector<cv::Mat> levels = pyramid(picture, search);
  Finds finds(picture, search);
  std::vector<DiscFit> found;
  // From the coarsest level to the finest that is needed.
  for (std::size_t k = levels.size(); k-- > 0;) {
    const int scale = 1 << k;
    if (scale * kSearchMax < search.min_radius) break;
    if (unwanted_beside(found, largest_from(scale * kSearchMax), search)) break;
    for (const Circle& c : vote(levels[k], scale)) finds.add(c);
    if (search.beside_best > 0) found = finds.discs();
  }
  found = finds.discs();
  if (found.size() > static_cast<std::size_t>(max_count)) found.resize(static_cast<std::size_t>(max_count));
  return found;
}

}  // namespace tribotrack::vision
