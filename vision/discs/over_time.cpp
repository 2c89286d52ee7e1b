// Discs over the frames: the first appearance of the part, its rest, and one rim in many frames.
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "vision/discs/disc_detection.h"
#include "vision/discs/first_appearance.h"
#include "vision/discs/rim_series.h"
#include "vision/io/levels.h"
#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr std::int64_t kLooks = 100;  ///< whole frames searched on the way, at most
constexpr double kMargin = 8;         ///< px around the disc that the rim's fit sees

bool nearly_whole(const DiscFit& fit) {
  return fit.coverage >= DiscSearch{}.min_coverage;
}

/// As clear as a disc found without a given place.
bool clear(const DiscFit& fit) {
  const DiscSearch usual;
  return nearly_whole(fit) && std::abs(fit.contrast) >= usual.min_clarity * fit.residual_rms &&
         fit.blur <= usual.max_blur_share * fit.circle.radius;
}

/// A part that comes in over the edge is taken for the template once all its surroundings are seen.
bool has_room(const Circle& c, const Rect& all) {
  const double reach = c.radius + kMargin;
  return c.x >= reach && c.y >= reach && c.x + reach < all.width && c.y + reach < all.height;
}

}  // namespace

std::optional<std::int64_t> arrival_at(FrameSource& source, std::int64_t first, std::int64_t last,
                                       const Circle& place, double capture) {
  const Rect window = window_about(
      {place.x, place.y}, place.radius + capture + std::max(kMargin, 0.2 * place.radius), source.bounds());
  Picture picture;
  for (std::int64_t index = first; index <= last; ++index) {
    source.read(index, window, picture);
    const auto fit = fit_disc(picture, {place.x - window.x, place.y - window.y, place.radius}, capture);
    if (fit && (index == first ? nearly_whole(*fit) : clear(*fit))) return index;
  }
  return std::nullopt;
}

std::optional<std::int64_t> arrival_anywhere(FrameSource& source, std::int64_t first, std::int64_t last,
                                             const DiscSearch& search) {
  Picture picture;
  const auto seen = [&](std::int64_t index) {
    source.read(index, source.bounds(), picture);
    if (index == first) return shows_disc(picture, search);
    const auto found = find_discs(picture, search, 1);
    return !found.empty() && has_room(found.front().circle, source.bounds());
  };
  const std::int64_t step = std::max<std::int64_t>(1, (last - first) / kLooks);
  std::int64_t without = first;
  if (seen(first)) return first;
  for (std::int64_t with = first + step; without < last; with = std::min(with + step, last)) {
    if (!seen(with)) {
      without = with;
      continue;
    }
    while (with - without > 1) {
      const std::int64_t middle = without + (with - without) / 2;
      (seen(middle) ? with : without) = middle;
    }
    return with;
  }
  return std::nullopt;
}

namespace {

constexpr double kStill = 0.5;     ///< px
constexpr double kBriefly = 0.05;  ///< of the frames: whatever rests for less moves
/// Where in the recording to look: not evenly, so that no circling motion is met in the same phase.
constexpr std::array<double, 4> kLookAt = {0.13, 0.38, 0.62, 0.87};
constexpr double kSeen = 0.2;  ///< of the score of the disc tracked

double distance(const Circle& a, const Circle& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

const DiscFit* nearest(const std::vector<DiscFit>& found, const Circle& place) {
  const DiscFit* best = nullptr;
  for (const DiscFit& f : found)
    if (distance(f.circle, place) < place.radius &&
        (!best || distance(f.circle, place) < distance(best->circle, place)))
      best = &f;
  return best;
}

/// The discs of a later frame that were not there in the first.
std::vector<Circle> newcomers(const std::vector<DiscFit>& found, const std::vector<DiscFit>& at_first,
                              const DiscFit& part) {
  std::vector<Circle> out;
  for (const DiscFit& f : found) {
    const bool known = std::ranges::any_of(at_first, [&](const DiscFit& other) {
      return distance(f.circle, other.circle) < std::max(f.circle.radius, other.circle.radius);
    });
    if (!known && f.score > kSeen * part.score) out.push_back(f.circle);
  }
  return out;
}

}  // namespace

std::int64_t frames_at_rest(const Track& track) {
  const TrackPoint* start = nullptr;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok) continue;
    if (!start) start = &p;
    if (std::hypot(p.x - start->x, p.y - start->y) > kStill) return static_cast<std::int64_t>(k);
  }
  return static_cast<std::int64_t>(track.points.size());
}

std::optional<DiscQuestion> question_of_rest(
    FrameSource& source, std::int64_t first, const Track& track,
    const std::function<std::vector<DiscFit>(const Picture&)>& find) {
  const auto total = static_cast<std::int64_t>(track.points.size());
  const std::int64_t rested = frames_at_rest(track);
  const auto seen = std::ranges::find(track.points, TrackStatus::ok, &TrackPoint::status);
  if (total < 2 || seen == track.points.end() ||
      static_cast<double>(rested) < kBriefly * static_cast<double>(total))
    return std::nullopt;
  const auto at_first = find(source.read(first));
  if (at_first.empty()) return std::nullopt;
  const Circle start{seen->x, seen->y, at_first.front().circle.radius};
  const DiscFit* part = nearest(at_first, start);
  if (!part) return std::nullopt;
  for (const double share : kLookAt) {
    const auto place = static_cast<std::int64_t>(share * static_cast<double>(total - 1));
    const auto found = find(source.read(first + place));
    const TrackPoint& p = track.points[static_cast<std::size_t>(place)];
    const Circle expected =
        p.status == TrackStatus::ok ? Circle{p.x, p.y, part->circle.radius} : part->circle;
    const DiscFit* here = nearest(found, expected);
    if (!here) continue;
    if (auto all = discs_alike(found, *here); all.size() > 1)
      return DiscQuestion{first + place, rested, std::move(all)};
    if (rested < total) continue;
    if (auto others = newcomers(found, at_first, *part); !others.empty()) {
      others.insert(others.begin(), here->circle);
      return DiscQuestion{first + place, rested, std::move(others)};
    }
  }
  return std::nullopt;
}

namespace {

constexpr std::int64_t kPatternReach = 32;  ///< frames on either side in which the disc looks alike
constexpr std::size_t kFewestFrames = 8;    ///< from which a pattern can be told from noise
constexpr std::int64_t kScatterReach = 8;   ///< frames on either side in which edges scatter alike
/// Hampel's psi, in usual residuals: proportional up to the first, level up to the second, 0 from the third.
constexpr double kBend = 2.5, kFall = 4, kGone = 8;
constexpr int kReweightings = 4;

/// Of the frames, first .. last.
struct Neighbours {
  std::size_t first = 0, last = 0;
  std::size_t count() const { return last - first + 1; }
};

Neighbours neighbours(const std::vector<RimFrame>& frames, std::size_t here, std::int64_t reach) {
  Neighbours n{here, here};
  while (n.first > 0 && frames[here].frame - frames[n.first - 1].frame <= reach) --n.first;
  while (n.last + 1 < frames.size() && frames[n.last + 1].frame - frames[here].frame <= reach) ++n.last;
  return n;
}

/// p_k about a frame, from all frames where too few are near; zero where too few show the sector.
std::vector<double> pattern_about(const std::vector<RimFrame>& frames, std::size_t here) {
  Neighbours near = neighbours(frames, here, kPatternReach);
  if (near.count() < kFewestFrames) near = {0, frames.size() - 1};
  std::vector<double> pattern(frames[here].rim.deviation.size(), 0), seen;
  for (std::size_t k = 0; k < pattern.size(); ++k) {
    seen.clear();
    for (std::size_t t = near.first; t <= near.last; ++t)
      if (frames[t].rim.information[k] > 0) seen.push_back(static_cast<double>(frames[t].rim.deviation[k]));
    if (2 * seen.size() >= kFewestFrames) pattern[k] = median(seen);
  }
  return pattern;
}

/// psi(r) / r.
double weight_of(double size) {
  if (size <= kBend) return 1;
  return kBend / size * std::clamp((kGone - size) / (kGone - kFall), 0.0, 1.0);
}

/// The edges of a frame less the pattern, and the circle through them. Each pulls by its information times
/// psi: what it is off, unless that is far more than usual (a lamp over the rim, a dot of the part).
struct CircleFit {
  std::vector<double> edge, information, psi;
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
};

class SeriesFit {
 public:
  SeriesFit(const std::vector<RimFrame>& frames, double noise_variance)
      : frames_(frames), noise_variance_(noise_variance), fits_(frames.size()) {
    const int count = static_cast<int>(frames.front().rim.deviation.size());
    for (int k = 0; k < count; ++k) {
      const Point u = sector_direction(k, count);
      directions_.emplace_back(u.x, u.y, 1);
    }
    take_out_pattern();
    for (CircleFit& fit : fits_) fit_circle(fit);
  }
  RimFix fix(std::size_t frame) const;

 private:
  void take_out_pattern();
  void fit_circle(CircleFit& fit) const;
  std::vector<double> scatter_about(std::size_t here) const;
  double own_excess(std::size_t here, const std::vector<double>& variance) const;

  const std::vector<RimFrame>& frames_;
  double noise_variance_;
  std::vector<Eigen::Vector3d> directions_;  ///< how a sector's edge moves with x, y, R
  std::vector<CircleFit> fits_;
  double usual_ = 0;  ///< residual, px
};

void SeriesFit::take_out_pattern() {
  std::vector<double> sizes;
  for (std::size_t t = 0; t < frames_.size(); ++t) {
    const RimSectors& rim = frames_[t].rim;
    const std::vector<double> pattern = pattern_about(frames_, t);
    fits_[t].information.assign(rim.information.begin(), rim.information.end());
    for (std::size_t k = 0; k < pattern.size(); ++k) {
      fits_[t].edge.push_back(static_cast<double>(rim.deviation[k]) - pattern[k]);
      if (rim.information[k] > 0) sizes.push_back(std::abs(fits_[t].edge[k]));
    }
  }
  usual_ = std::max(1e-6, kNormalMad * median(sizes));
}

void SeriesFit::fit_circle(CircleFit& fit) const {
  std::vector<double> residual(directions_.size(), 0);
  for (int round = 0; round <= kReweightings; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < directions_.size(); ++k) {
      const Eigen::Vector3d& u = directions_[k];
      const double weight = fit.information[k] * weight_of(std::abs(residual[k]) / usual_);
      normal += weight * u * u.transpose();
      right += weight * fit.edge[k] * u;
    }
    fit.inverse = normal.inverse();
    fit.step = fit.inverse * right;
    for (std::size_t k = 0; k < directions_.size(); ++k)
      residual[k] = fit.edge[k] - directions_[k].dot(fit.step);
  }
  for (const double r : residual) fit.psi.push_back(r * weight_of(std::abs(r) / usual_));
}

/// v_tk, corrected for the three numbers that each frame's circle took and for the pattern; at least what the
/// noise does.
std::vector<double> SeriesFit::scatter_about(std::size_t here) const {
  const Neighbours near = neighbours(frames_, here, kScatterReach);
  const auto sectors = static_cast<double>(directions_.size()), all = static_cast<double>(frames_.size());
  const double taken = sectors / (sectors - 3) * (frames_.size() >= kFewestFrames ? all / (all - 1) : 1);
  std::vector<double> variance(directions_.size(), 0);
  for (std::size_t k = 0; k < variance.size(); ++k) {
    double squares = 0, count = 0;
    for (std::size_t t = near.first; t <= near.last; ++t) {
      if (!(fits_[t].information[k] > 0)) continue;
      squares += fits_[t].psi[k] * fits_[t].psi[k];
      ++count;
    }
    const double information = fits_[here].information[k];
    if (information > 0) variance[k] = std::max(taken * squares / count, noise_variance_ / information);
  }
  return variance;
}

/// A frame that is worse than its neighbours by more than chance says so.
double SeriesFit::own_excess(std::size_t here, const std::vector<double>& variance) const {
  const CircleFit& fit = fits_[here];
  const double sectors = static_cast<double>(variance.size());
  double own = 0, usual = 0;
  for (std::size_t k = 0; k < variance.size(); ++k) {
    own += fit.information[k] * fit.psi[k] * fit.psi[k] * sectors / (sectors - 3);
    usual += fit.information[k] * variance[k];
  }
  return own > (1 + 3 * std::sqrt(2 / (sectors - 3))) * usual ? own / usual : 1;
}

RimFix SeriesFit::fix(std::size_t frame) const {
  const CircleFit& fit = fits_[frame];
  const std::vector<double> variance = scatter_about(frame);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < variance.size(); ++k)
    scatter +=
        fit.information[k] * fit.information[k] * variance[k] * directions_[k] * directions_[k].transpose();
  const Eigen::Matrix3d covariance = own_excess(frame, variance) * fit.inverse * scatter * fit.inverse;
  const Circle& c = frames_[frame].rim.circle;
  return {{c.x + fit.step(0), c.y + fit.step(1)}, covariance.topLeftCorner<2, 2>()};
}

}  // namespace

std::vector<RimFix> fix_centres(const std::vector<RimFrame>& frames, double noise_variance) {
  std::vector<RimFix> fixes;
  if (frames.empty()) return fixes;
  for (const RimFrame& f : frames)
    if (f.rim.deviation.size() != frames.front().rim.deviation.size())
      throw std::invalid_argument("rims measured with different numbers of sectors");
  const SeriesFit series(frames, noise_variance);
  for (std::size_t t = 0; t < frames.size(); ++t) fixes.push_back(series.fix(t));
  return fixes;
}

}  // namespace tribotrack::vision
