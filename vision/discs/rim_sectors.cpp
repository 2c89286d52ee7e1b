#include "vision/discs/rim_sectors.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/io/levels.h"
#include "vision/kernels/bspline.h"
#include "vision/kernels/median.h"
#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSectorLength = 4.5;  ///< px: the rays in it fix three numbers well
constexpr int kFewestSectors = 8, kMostSectors = 72;
constexpr double kBandInBlurs = 4, kLeastBand = 4;  ///< px: what is farther from the edge says nothing of it
constexpr double kLeastBlur = 0.4;                  ///< px: a pixel alone blurs by 0.29
constexpr double kSeen = 0.6;                ///< of a rim: more than chance, and most highlights, leave
constexpr double kLeastStep = 0.15;          ///< of the median one: less is no edge
constexpr double kLeastOff = 0.5, kOff = 5;  ///< px, usual deviations: an edge so far off is not the rim's
constexpr double kHuber = 2.5;               ///< usual deviations from which a sector counts less
constexpr int kIterations = 12, kReweightings = 4;
constexpr double kSettled = 1e-3;  ///< px: a tenth of what the best rims tell
constexpr double kContext = 8;     ///< px for the spline

/// Sectors about 4.5 px long.
int rim_sector_count(double radius) {
  return std::clamp(static_cast<int>(std::lround(2 * kPi * radius / kSectorLength)), kFewestSectors,
                    kMostSectors);
}

/// Unit vector towards the middle of a sector; they follow each other by growing angle from the direction -x.
Point sector_direction(int sector, int count) {
  const double angle = 2 * kPi * ((sector + 0.5) / count - 0.5);
  return {std::cos(angle), std::sin(angle)};
}

struct Edge {
  bool seen = false;
  double step = 0, displacement = 0, information = 0;
};

class SectorFit {
 public:
  SectorFit(const Picture& picture, const Circle& start, double blur)
      : start_(start),
        blur_(std::max(blur, kLeastBlur)),
        band_(std::min(std::max(kBandInBlurs * blur_, kLeastBand), 0.6 * start.radius)),
        count_(rim_sector_count(start.radius)),
        rays_(std::max(1, static_cast<int>(std::lround(2 * kPi * start.radius / count_)))),
        bounds_(bounds_of(picture)),
        window_(window_about({start.x, start.y}, start.radius + 3 * band_ + kContext, bounds_)),
        spline_(part_of(picture, window_)),
        circle_(start),
        directions_(static_cast<std::size_t>(count_)),
        edges_(static_cast<std::size_t>(count_)) {
    for (int k = 0; k < count_; ++k) {
      const Point u = sector_direction(k, count_);
      directions_[static_cast<std::size_t>(k)] = {u.x, u.y, 1};
    }
    learn_profile();
  }

  std::optional<RimSectors> run() {
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
    }
    return std::nullopt;
  }

 private:
  void learn_profile();
  void measure_edges();
  Eigen::Vector3d fit_circle();
  bool walked_away() const {
    return distance(circle_, start_) > 2 * band_ || std::abs(circle_.radius - start_.radius) > 0.5 * band_;
  }
  RimSectors result() const;

  Circle start_;
  double blur_, band_;
  int count_, rays_;      ///< sectors, rays in each
  Rect bounds_, window_;  ///< of the picture; about the rim
  QuinticSpline spline_;  ///< of the window
  Circle circle_;
  Eigen::ArrayXd offset_, weight_;           ///< of the places along a ray, px from the edge
  Eigen::MatrixX3d profile_;                 ///< 1, Phi, phi / s there
  Eigen::Matrix3d inverse_;                  ///< of profile^T weight profile
  std::vector<Eigen::Vector3d> directions_;  ///< how each edge moves with x, y, R
  std::vector<Edge> edges_;
  double seen_ = 0, unevenness_ = 0, squares_ = 0, explained_ = 0;
};

/// Regression on 1, Phi, phi / s: outside level, step, step times the edge's displacement. Places within a
/// blur or two of the edge say where it is; farther ones, which only tell the levels, count less the farther
/// they are, for levels change (a slope, a glint beside the rim).
void SectorFit::learn_profile() {
  const int reach = static_cast<int>(band_);
  offset_ = Eigen::ArrayXd::LinSpaced(2 * reach + 1, -reach, reach);
  const Eigen::ArrayXd t = -offset_ / blur_, bell = (-0.5 * t.square()).exp();
  weight_ = (-t.square() / 8).exp();
  profile_.resize(offset_.size(), 3);
  profile_.col(0).setOnes();
  profile_.col(1) = t.unaryExpr([](double v) { return 0.5 * std::erfc(-v / std::numbers::sqrt2); });
  profile_.col(2) = bell / (blur_ * std::sqrt(2 * kPi));
  inverse_ = (profile_.transpose() * weight_.matrix().asDiagonal() * profile_).inverse();
}

void SectorFit::measure_edges() {
  const auto places = static_cast<std::size_t>(offset_.size());
  std::vector<float> x, y, level(places * static_cast<std::size_t>(rays_ * count_));
  std::vector<bool> whole(edges_.size(), true);  // in the picture
  for (int k = 0; k < rays_ * count_; ++k) {
    const Point u = sector_direction(k, rays_ * count_);
    for (const double offset : offset_) {
      const double px = circle_.x + (circle_.radius + offset) * u.x,
                   py = circle_.y + (circle_.radius + offset) * u.y;
      x.push_back(static_cast<float>(px - window_.x));
      y.push_back(static_cast<float>(py - window_.y));
      if (px < 0 || py < 0 || px > bounds_.width - 1 || py > bounds_.height - 1)
        whole[static_cast<std::size_t>(k / rays_)] = false;
    }
  }
  spline_.sample_places(x, y, level.data(), nullptr, nullptr);
  std::vector<double> steps;
  double residual = 0, sum = 0, squares = 0, weight = 0;
  for (std::size_t k = 0; k < edges_.size(); ++k) {
    Edge& edge = edges_[k] = {};
    if (!whole[k]) continue;
    const Eigen::MatrixXd levels =
        Eigen::Map<const Eigen::MatrixXf>(level.data() + k * places * static_cast<std::size_t>(rays_),
                                          offset_.size(), rays_)
            .cast<double>();
    const Eigen::MatrixXd weighted = weight_.matrix().asDiagonal() * levels;
    const Eigen::Vector3d right = profile_.transpose() * weighted.rowwise().sum();
    const Eigen::Vector3d fit = inverse_ * right / rays_;
    edge.step = fit(1);
    edge.displacement = fit(2) / fit(1);
    edge.information = rays_ * fit(1) * fit(1) / inverse_(2, 2);
    edge.seen = std::isfinite(edge.displacement);
    if (edge.seen) steps.push_back(std::abs(edge.step));
    const double square = weighted.cwiseProduct(levels).sum();
    residual += std::max(0.0, square - fit.dot(right));
    sum += right(0);
    squares += square;
    weight += rays_ * weight_.sum();
  }
  const double contrast = median(steps);
  seen_ = 0;
  for (Edge& e : edges_) {
    e.seen = e.seen && std::abs(e.step) > kLeastStep * contrast && std::abs(e.displacement) < 0.5 * band_;
    seen_ += e.seen;
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
  const double most = std::max(kLeastOff, kOff * unevenness_), huber = kHuber * unevenness_;
  double seen = 0;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero(), scatter = normal;
  for (std::size_t k = 0; k < edges_.size(); ++k) {
    const Edge& e = edges_[k];
    const double off = std::abs(e.displacement);
    if (!e.seen || !(off < most)) continue;
    ++seen;
    const Eigen::Matrix3d square = directions_[k] * directions_[k].transpose();
    normal += e.information * std::min(1.0, huber / std::max(1e-9, off)) * square;
    scatter += std::max(std::pow(e.information * std::min(huber, off), 2), e.information * squares_) * square;
  }
  const Eigen::Matrix3d inverse = normal.inverse();
  out.covariance = (seen / std::max(1.0, seen - 3) * inverse * scatter * inverse).topLeftCorner<2, 2>();
  out.coverage = seen / count_;
  out.unevenness = unevenness_;
  out.correlation = std::sqrt(std::max(0.0, explained_));
  out.residual_rms = std::sqrt(squares_);
  return out;
}

}  // namespace

std::optional<RimSectors> measure_rim_sectors(const Picture& picture, const Circle& start, double blur) {
  if (!(start.radius >= 2)) return std::nullopt;
  return SectorFit(picture, start, blur).run();
}

bool same_rim(const RimSectors& seen, const RimShape& known) {
  constexpr double kRadiusShare = 0.06, kRadiusSlack = 1;  // px; a chamfer shows its outer or its inner edge
  constexpr double kUneven = 3, kUnevenSlack = 0.1;        // px
  return seen.coverage >= kSeen &&
         std::abs(seen.circle.radius - known.radius) < std::max(kRadiusSlack, kRadiusShare * known.radius) &&
         seen.unevenness < kUneven * known.unevenness + kUnevenSlack;
}

RimShape shape_of(const RimSectors& seen, double blur, const Point& centre) {
  return {seen.circle.radius, blur, seen.unevenness, {centre.x - seen.circle.x, centre.y - seen.circle.y}};
}

}  // namespace tribotrack::vision
