#include "vision/discs/rim_sectors.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "vision/discs/rim_fit.h"
#include "vision/kernels/median.h"
#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSectorLength = 4.5;  ///< px: the rim's pixels in it fix three numbers well
constexpr int kFewestSectors = 8, kMostSectors = 72;
constexpr double kBandInBlurs = 4, kLeastBand = 4;  ///< px: what is farther from the edge says nothing of it
constexpr double kLeastBlur = 0.4;                  ///< px: a pixel alone blurs by 0.29
constexpr int kFewestPixels = 6;                    ///< in a sector
constexpr double kSeen = 0.6;                ///< of a rim: more than chance, and most highlights, leave
constexpr double kLeastStep = 0.15;          ///< of the median one: less is no edge
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

/// What all pixels share of a circle: its centre and radius, and one over the blur.
struct Ring {
  double x, y, radius, inverse;
};

using Lanes = VectorOf<double, 4>::type;
constexpr std::size_t kLanes = sizeof(Lanes) / sizeof(double);
/// In the order of the kernel: w, w Phi, w Phi^2, w s, w s Phi, w s^2 with the slope s = phi / blur, then
/// with the level l: w l, w l Phi, w l s, w l^2.
using SectorSums = std::array<double, 10>;

/// Pixels first .. last - 1, a whole number of vectors; those that only fill them up have no weight.
TRIBOTRACK_KERNEL void sums_of_sector(const Ring& ring, const RimPixels& pixels, std::size_t first,
                                      std::size_t last, SectorSums& out) {
  Lanes sums[10] = {};
  for (std::size_t i = first; i < last; i += kLanes) {
    Lanes x, y, level, counts, rho = {};
    load(pixels.x.data() + i, x);
    load(pixels.y.data() + i, y);
    load(pixels.level.data() + i, level);
    load(pixels.weight.data() + i, counts);
    const Lanes dx = x - ring.x, dy = y - ring.y, square = dx * dx + dy * dy;
    for (std::size_t k = 0; k < kLanes; ++k) rho[k] = std::sqrt(square[k]);
    const Lanes t = (ring.radius - rho) * ring.inverse;
    // exp(-t^2 / 8) as the 16th power of a short series; it is nothing where that is not exact.
    const Lanes far = t * t, z = (far > 150.0 ? Lanes{} + 150.0 : far) * (-1.0 / 128);
    const Lanes e =
        1 + z * (1 + z * (1.0 / 2) *
                         (1 + z * (1.0 / 3) *
                                  (1 + z * (1.0 / 4) *
                                           (1 + z * (1.0 / 5) * (1 + z * (1.0 / 6) * (1 + z * (1.0 / 7)))))));
    const Lanes e2 = e * e, e4 = e2 * e2, e8 = e4 * e4, w = e8 * e8, w2 = w * w, bell = w2 * w2;
    // Phi to 1e-7: Abramowitz and Stegun, 7.1.26.
    const Lanes size = t < 0.0 ? -t : t, q = 1 / (1 + 0.3275911 * std::numbers::sqrt2 / 2 * size);
    const Lanes tail =
        0.5 * bell * q *
        (0.254829592 + q * (-0.284496736 + q * (1.421413741 + q * (-1.453152027 + q * 1.061405429))));
    const Lanes value = t < 0.0 ? tail : 1 - tail;
    const Lanes slope = bell * (ring.inverse * std::numbers::inv_sqrtpi / std::numbers::sqrt2);
    const Lanes weight = w * counts, of_value = weight * value, of_slope = weight * slope;
    sums[0] += weight;
    sums[1] += of_value;
    sums[2] += of_value * value;
    sums[3] += of_slope;
    sums[4] += of_slope * value;
    sums[5] += of_slope * slope;
    sums[6] += weight * level;
    sums[7] += of_value * level;
    sums[8] += of_slope * level;
    sums[9] += weight * level * level;
  }
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = sum(sums[k]);
}

#define TRIBOTRACK_VARIANT(suffix, ...)                                                                     \
  __VA_ARGS__ void sums_##suffix(const Ring& ring, const RimPixels& pixels, const std::size_t* begin,       \
                                 std::size_t sectors, SectorSums* out) {                                    \
    for (std::size_t k = 0; k < sectors; ++k) sums_of_sector(ring, pixels, begin[k], begin[k + 1], out[k]); \
  }

TRIBOTRACK_VARIANT(baseline)
TRIBOTRACK_VARIANT(avx2, TRIBOTRACK_AVX2)
#undef TRIBOTRACK_VARIANT

/// Angles of the pixels about a centre in whole turns, 0 in the direction -x, to 3e-9: Abramowitz and Stegun,
/// 4.4.49.
TRIBOTRACK_CLONES void turns_of(const double* x, const double* y, std::size_t count, double centre_x,
                                double centre_y, double* out) {
  for (std::size_t i = 0; i < count; ++i) {
    const double dx = x[i] - centre_x, dy = y[i] - centre_y;
    const double ax = dx < 0 ? -dx : dx, ay = dy < 0 ? -dy : dy;
    const double high = ax > ay ? ax : ay, low = ax > ay ? ay : ax;
    const double a = low / (high + 1e-30), s = a * a;
    double angle = -0.0161657367 + s * 0.0028662257;
    angle = -0.1420889944 + s * (0.1065626393 + s * (-0.0752896400 + s * (0.0429096138 + s * angle)));
    angle = a * (1 + s * (-0.3333314528 + s * (0.1999355085 + s * angle)));
    angle = ay > ax ? kPi / 2 - angle : angle;
    angle = dx < 0 ? kPi - angle : angle;
    out[i] = 0.5 + (dy < 0 ? -angle : angle) / (2 * kPi);
  }
}

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
  RimPixels pixels_;                         ///< sector by sector, each filled up to whole vectors
  std::vector<std::size_t> begin_;           ///< of each sector's pixels, and the end
  std::vector<int> sizes_;                   ///< pixels in each sector
  std::vector<Eigen::Vector3d> directions_;  ///< how each edge moves with x, y, R
  std::vector<Edge> edges_;
  double seen_ = 0, contrast_ = 0, unevenness_ = 0, squares_ = 0, explained_ = 0;
};

void SectorFit::choose_pixels() {
  chosen_ = circle_;
  const RimPixels near = rim_pixels(picture_, circle_, band_);
  const std::size_t count = near.x.size(), sectors = edges_.size();
  std::vector<double> turn(count);
  turns_of(near.x.data(), near.y.data(), count, circle_.x, circle_.y, turn.data());
  std::vector<std::size_t> sector(count);
  sizes_.assign(sectors, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const auto k = static_cast<int>(turn[i] * count_);
    sector[i] = static_cast<std::size_t>(std::clamp(k, 0, count_ - 1));
    ++sizes_[sector[i]];
  }
  begin_.assign(sectors + 1, 0);
  for (std::size_t k = 0; k < sectors; ++k)
    begin_[k + 1] = begin_[k] + (static_cast<std::size_t>(sizes_[k]) + kLanes - 1) / kLanes * kLanes;
  for (auto* v : {&pixels_.x, &pixels_.y, &pixels_.level, &pixels_.weight}) v->assign(begin_.back(), 0);
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t to = next[sector[i]]++;
    pixels_.x[to] = near.x[i];
    pixels_.y[to] = near.y[i];
    pixels_.level[to] = near.level[i];
    pixels_.weight[to] = 1;
  }
}

Edge edge_of(const Sums& s) {
  Edge edge;
  if (s.pixels < kFewestPixels) return edge;
  Eigen::Matrix3d inverse;
  bool regular = false;
  s.normal.computeInverseWithCheck(inverse, regular);
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
  std::vector<SectorSums> raw(edges_.size());
  static const auto sums_of = runs_avx2() ? sums_avx2 : sums_baseline;
  sums_of({circle_.x, circle_.y, circle_.radius, 1 / blur_}, pixels_, begin_.data(), raw.size(), raw.data());
  std::vector<Sums> sums(edges_.size());
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const SectorSums& r = raw[k];
    sums[k].normal << r[0], r[1], r[3], r[1], r[2], r[4], r[3], r[4], r[5];
    sums[k].right << r[6], r[7], r[8];
    sums[k].squares = r[9];
    sums[k].pixels = sizes_[k];
  }
  std::ranges::transform(sums, edges_.begin(), edge_of);

  std::vector<double> steps;
  for (const Edge& e : edges_)
    if (e.seen) steps.push_back(std::abs(e.step));
  contrast_ = median(steps);
  seen_ = 0;
  for (Edge& e : edges_) {
    e.seen = e.seen && std::abs(e.step) > kLeastStep * contrast_ && std::abs(e.displacement) < 0.5 * band_;
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
  constexpr double kRadiusShare = 0.06, kRadiusSlack = 1;  // px; a chamfer shows its outer or its inner edge
  constexpr double kUneven = 3, kUnevenSlack = 0.1;        // px
  return seen.coverage >= kSeen &&
         std::abs(seen.circle.radius - known.radius) < std::max(kRadiusSlack, kRadiusShare * known.radius) &&
         seen.unevenness < kUneven * known.unevenness + kUnevenSlack;
}

RimFix fix_of(const RimSectors& seen, const RimShape& known, double noise_variance) {
  const int count = static_cast<int>(seen.deviation.size());
  std::vector<Eigen::Vector3d> rows;
  std::vector<double> information, off;
  for (int k = 0; k < count; ++k) {
    const auto at = static_cast<std::size_t>(k);
    if (!(seen.information[at] > 0)) continue;
    const Point u = sector_direction(k, count);
    rows.emplace_back(u.x, u.y, 1);
    information.push_back(static_cast<double>(seen.information[at]));
    off.push_back(static_cast<double>(seen.deviation[at] - known.pattern[at]));
  }
  std::vector<double> sizes;
  for (const double d : off) sizes.push_back(std::abs(d));
  const double most = kHuber * std::max(1e-6, kNormalMad * median(sizes));
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero(), scatter = normal;
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double weight = information[k] * std::min(1.0, most / std::max(1e-9, std::abs(off[k])));
    normal += weight * rows[k] * rows[k].transpose();
    right += weight * off[k] * rows[k];
  }
  const Eigen::Matrix3d inverse = normal.inverse();
  const Eigen::Vector3d step = inverse * right;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double left = std::min(most, std::abs(off[k] - rows[k].dot(step)));
    scatter += std::max(std::pow(information[k] * left, 2), information[k] * noise_variance) * rows[k] *
               rows[k].transpose();
  }
  const auto sectors = static_cast<double>(rows.size());
  const Eigen::Matrix3d covariance = sectors / std::max(1.0, sectors - 3) * inverse * scatter * inverse;
  return {{seen.circle.x + step(0) + known.offset.x, seen.circle.y + step(1) + known.offset.y},
          covariance.topLeftCorner<2, 2>()};
}

RimShape shape_of(const RimSectors& seen, double blur, const Point& centre) {
  return {seen.circle.radius,
          blur,
          seen.unevenness,
          seen.deviation,
          {centre.x - seen.circle.x, centre.y - seen.circle.y}};
}

}  // namespace tribotrack::vision
