#include "vision/discs/rim_sectors.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/discs/rim_fit.h"
#include "vision/discs/rim_model.h"
#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr double kPi = std::numbers::pi;
const double kPeak = std::sqrt(2 * kPi);  ///< of the normal density, inverted
constexpr double kSectorLength = 4.5;     ///< px: the rim's pixels in it fix three numbers well
constexpr int kFewestSectors = 8, kMostSectors = 72;
constexpr double kBandInBlurs = 4, kLeastBand = 4;  ///< px: what is farther from the edge says nothing of it
constexpr double kLeastBlur = 0.4;                  ///< px: a pixel alone blurs by 0.29
constexpr int kFewestPixels = 6;                    ///< in a sector
constexpr double kMayBeHidden = 0.05;               ///< of a rim: a fingertip over it hides more
constexpr double kLeastStep = 0.3;                  ///< of the median one: less is no edge
constexpr double kLeastOff = 0.5, kOff = 5;  ///< px, usual deviations: an edge so far off is not the rim's
constexpr double kHuber = 2.5;               ///< usual deviations from which a sector counts less
constexpr int kIterations = 12, kReweightings = 4;
constexpr double kSettled = 1e-3;  ///< px: a tenth of what the best rims tell
constexpr double kAgain = 0.3;     ///< px of motion after which the pixels are chosen anew

/// Regression on 1, Phi, phi / s: outside level, step, step times the edge's displacement. Pixels within a
/// blur or two of the edge say where it is; farther ones, which only tell the levels, count less the farther
/// they are, for levels change (a slope, a glint beside the rim).
struct Sums {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double squares = 0;
  int pixels = 0;
};

struct Edge {
  bool seen = false;
  double step = 0, displacement = 0, information = 0, residual = 0;
};

class SectorFit {
 public:
  SectorFit(const Picture& picture, const Circle& start, double blur)
      : picture_(picture),
        start_(start),
        blur_(std::max(blur, kLeastBlur)),
        band_(std::min(std::max(kBandInBlurs * blur_, kLeastBand), 0.6 * start.radius)),
        count_(rim_sector_count(start.radius)),
        circle_(start),
        directions_(static_cast<std::size_t>(count_)),
        edges_(static_cast<std::size_t>(count_)) {
    for (int k = 0; k < count_; ++k) {
      const Point u = sector_direction(k, count_);
      directions_[static_cast<std::size_t>(k)] = {u.x, u.y, 1};
    }
  }

  std::optional<RimSectors> run() {
    choose_pixels();
    for (int k = 0; k < kIterations; ++k) {
      measure_edges();
      if (seen_ < 0.5 * count_) return std::nullopt;
      const Eigen::Vector3d step = fit_circle();
      if (!step.allFinite()) return std::nullopt;
      // The edges' displacement is linear for a blur's width.
      const double size = step.cwiseAbs().maxCoeff(), brake = size > blur_ ? blur_ / size : 1;
      circle_ = {circle_.x + brake * step(0), circle_.y + brake * step(1), circle_.radius + brake * step(2)};
      if (walked_away()) return std::nullopt;
      if (size < kSettled) return result();
      if (std::hypot(circle_.x - chosen_.x, circle_.y - chosen_.y) +
              std::abs(circle_.radius - chosen_.radius) >
          kAgain)
        choose_pixels();
    }
    return std::nullopt;
  }

 private:
  void choose_pixels();
  void measure_edges();
  Eigen::Vector3d fit_circle();
  bool walked_away() const {
    return std::hypot(circle_.x - start_.x, circle_.y - start_.y) > 2 * band_ ||
           std::abs(circle_.radius - start_.radius) > 0.5 * band_;
  }
  RimSectors result() const;

  const Picture& picture_;
  Circle start_;
  double blur_, band_;
  int count_;
  Circle circle_, chosen_;
  RimPixels pixels_;
  std::vector<std::size_t> sector_;          ///< of each pixel
  std::vector<Eigen::Vector3d> directions_;  ///< how each edge moves with x, y, R
  std::vector<Edge> edges_;
  double seen_ = 0, contrast_ = 0, unevenness_ = 0, squares_ = 0, explained_ = 0;
};

void SectorFit::choose_pixels() {
  chosen_ = circle_;
  pixels_ = rim_pixels(picture_, circle_, band_);
  sector_.resize(pixels_.x.size());
  for (std::size_t i = 0; i < sector_.size(); ++i) {
    const double turn = 0.5 + std::atan2(pixels_.y[i] - circle_.y, pixels_.x[i] - circle_.x) / (2 * kPi);
    sector_[i] = std::min(static_cast<std::size_t>(turn * count_), static_cast<std::size_t>(count_ - 1));
  }
}

Edge edge_of(const Sums& s) {
  Edge edge;
  if (s.pixels < kFewestPixels) return edge;
  const Eigen::Matrix3d normal = s.normal.selfadjointView<Eigen::Lower>();
  Eigen::Matrix3d inverse;
  bool regular = false;
  normal.computeInverseWithCheck(inverse, regular);
  if (!regular) return edge;
  const Eigen::Vector3d fit = inverse * s.right;
  edge.step = fit(1);
  edge.displacement = fit(2) / fit(1);
  edge.information = fit(1) * fit(1) / inverse(2, 2);
  edge.residual = std::max(0.0, s.squares - fit.dot(s.right));
  edge.seen = std::isfinite(edge.displacement);
  return edge;
}

void SectorFit::measure_edges() {
  std::vector<Sums> sums(edges_.size());
  const double inverse = 1 / blur_;
  for (std::size_t i = 0; i < sector_.size(); ++i) {
    Sums& s = sums[sector_[i]];
    const double dx = pixels_.x[i] - circle_.x, dy = pixels_.y[i] - circle_.y;
    const double rho = std::sqrt(dx * dx + dy * dy);
    const auto [value, density] = normal_step((circle_.radius - rho) * inverse);
    const double weight = std::sqrt(std::sqrt(kPeak * density));  // exp(-t^2 / 8)
    const double slope = density * inverse, level = pixels_.level[i];
    s.normal(0, 0) += weight;
    s.normal(1, 0) += weight * value;
    s.normal(1, 1) += weight * value * value;
    s.normal(2, 0) += weight * slope;
    s.normal(2, 1) += weight * slope * value;
    s.normal(2, 2) += weight * slope * slope;
    s.right += weight * level * Eigen::Vector3d(1, value, slope);
    s.squares += weight * level * level;
    ++s.pixels;
  }
  std::ranges::transform(sums, edges_.begin(), edge_of);

  std::vector<double> steps;
  for (const Edge& e : edges_)
    if (e.seen) steps.push_back(e.step);
  contrast_ = median(steps);
  seen_ = 0;
  for (Edge& e : edges_) {
    e.seen = e.seen && e.step / contrast_ > kLeastStep && std::abs(e.displacement) < 0.5 * band_;
    seen_ += e.seen;
  }
  double residual = 0, sum = 0, squares = 0, weight = 0;
  for (std::size_t k = 0; k < edges_.size(); ++k) {
    residual += edges_[k].residual;
    sum += sums[k].right(0);
    squares += sums[k].squares;
    weight += sums[k].normal(0, 0);
  }
  squares_ = residual / std::max(1.0, weight - 3.0 * count_);
  explained_ = 1 - residual / std::max(1e-9, squares - sum * sum / std::max(1.0, weight));
}

/// Step of centre and radius; Huber's weights about the circle.
Eigen::Vector3d SectorFit::fit_circle() {
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
  std::vector<double> sizes;
  for (int round = 0; round <= kReweightings; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < edges_.size(); ++k) {
      const Edge& e = edges_[k];
      if (!e.seen) continue;
      const Eigen::Vector3d& row = directions_[k];
      const double off = round == 0 ? 0 : std::abs(e.displacement - row.dot(step));
      const double weight = e.information * (off > kHuber * unevenness_ ? kHuber * unevenness_ / off : 1);
      normal += weight * row * row.transpose();
      right += weight * e.displacement * row;
    }
    step = normal.inverse() * right;
    sizes.clear();
    for (std::size_t k = 0; k < edges_.size(); ++k)
      if (edges_[k].seen) sizes.push_back(std::abs(edges_[k].displacement - directions_[k].dot(step)));
    unevenness_ = std::max(1e-6, kNormalMad * median(sizes));
  }
  return step;
}

RimSectors SectorFit::result() const {
  RimSectors out;
  out.circle = circle_;
  const double most = std::max(kLeastOff, kOff * unevenness_);
  double seen = 0;
  for (const Edge& e : edges_) {
    const bool of_rim = e.seen && std::abs(e.displacement) < most;
    out.deviation.push_back(of_rim ? static_cast<float>(e.displacement) : 0);
    out.information.push_back(of_rim ? static_cast<float>(e.information) : 0);
    seen += of_rim;
  }
  out.contrast = contrast_;
  out.coverage = seen / count_;
  out.unevenness = unevenness_;
  out.correlation = std::sqrt(std::max(0.0, explained_));
  out.residual_rms = std::sqrt(squares_);
  return out;
}

}  // namespace

int rim_sector_count(double radius) {
  return std::clamp(static_cast<int>(std::lround(2 * kPi * radius / kSectorLength)), kFewestSectors,
                    kMostSectors);
}

Point sector_direction(int sector, int count) {
  const double angle = 2 * kPi * ((sector + 0.5) / count - 0.5);
  return {std::cos(angle), std::sin(angle)};
}

std::optional<RimSectors> measure_rim_sectors(const Picture& picture, const Circle& start, double blur) {
  if (!(start.radius >= 2)) return std::nullopt;
  return SectorFit(picture, start, blur).run();
}

bool same_rim(const RimSectors& seen, const RimShape& known) {
  const auto sectors = static_cast<double>(seen.deviation.size());
  return (1 - seen.coverage) * sectors <= std::max(1.0, kMayBeHidden * sectors) + 0.5 &&
         usable_rim(seen, known);
}

bool usable_rim(const RimSectors& seen, const RimShape& known) {
  constexpr double kRadiusShare = 0.04, kRadiusSlack = 0.5;  // px; motion blur widens a rim
  constexpr double kLeastContrast = 0.5, kMostContrast = 2;  // light changes
  constexpr double kUneven = 3, kUnevenSlack = 0.1;          // px
  const double share = seen.contrast / known.contrast;
  return share > kLeastContrast && share < kMostContrast &&
         std::abs(seen.circle.radius - known.radius) < std::max(kRadiusSlack, kRadiusShare * known.radius) &&
         seen.unevenness < kUneven * known.unevenness + kUnevenSlack;
}

RimShape shape_of(const RimSectors& seen, double blur) {
  return {seen.circle.radius, blur, seen.contrast, seen.unevenness};
}

}  // namespace tribotrack::vision
