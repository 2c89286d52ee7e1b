#include "vision/tracking/rim_track.h"

#include <algorithm>
#include <cmath>

#include "vision/discs/mean_radius.h"
#include "vision/discs/rim_series.h"
#include "vision/io/levels.h"
#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kFewest = 4;  ///< comparisons from which to conclude
constexpr double kChance = 3;       ///< standard deviations of a variance estimate
constexpr double kMargin = 8;       ///< px around the disc that are read

double variance(const Eigen::Matrix2d& covariance) {
  return 0.5 * covariance.trace();
}

double variance(const TrackPoint& p) {
  return 0.5 * (p.sigma_x * p.sigma_x + p.sigma_y * p.sigma_y);
}

/// Template minus rim where both measured, and what follows for either.
class Comparison {
 public:
  void add(const TrackPoint& p, const RimFix& rim) {
    of_template_.push_back(variance(p));
    of_rim_.push_back(variance(rim.covariance));
    x_.push_back(p.x - rim.centre.x);
    y_.push_back(p.y - rim.centre.y);
  }
  std::size_t count() const { return x_.size(); }
  bool enough() const { return count() >= kFewest; }
  double rim_variance() const { return middle(of_rim_); }
  double template_variance() const {
    const double claimed = middle(of_template_), both = claimed + rim_variance();
    const double differ = 0.5 * (spread(x_) + spread(y_));
    const double chance = kChance * std::sqrt(1.0 / static_cast<double>(std::max<std::size_t>(1, count())));
    return differ > (1 + chance) * both ? differ - rim_variance() : claimed;
  }
  /// Between the two centres: the rim's is where the edges are, the template's where its first frame says.
  Point offset() const { return enough() ? Point{middle(x_), middle(y_)} : Point{}; }

 private:
  static double middle(std::vector<double> values) { return median(values); }
  static double spread(const std::vector<double>& values) {
    double sum = 0, squares = 0;
    for (const double v : values) {
      sum += v;
      squares += v * v;
    }
    const auto n = static_cast<double>(values.size());
    return n > 1 ? (squares - sum * sum / n) / (n - 1) : 0;
  }
  std::vector<double> of_template_, of_rim_, x_, y_;
};

void put(TrackPoint& point, const RimFix& fix, const RimSectors& rim, const Point& offset) {
  point.x = fix.centre.x + offset.x;
  point.y = fix.centre.y + offset.y;
  point.sigma_x = std::sqrt(fix.covariance(0, 0));
  point.sigma_y = std::sqrt(fix.covariance(1, 1));
  point.rho_xy = fix.covariance(0, 1) / (point.sigma_x * point.sigma_y);
  point.ncc = rim.correlation;
}

}  // namespace

std::optional<RimSectors> RimTrack::measure(FrameSource& source, std::int64_t index,
                                            const Point& centre) const {
  const double reach = shape_->radius + std::max(kMargin, 5 * shape_->blur);
  const Rect window = window_about(centre, reach, source.bounds());
  Picture picture;
  source.read(index, window, picture);
  auto rim =
      measure_rim_sectors(picture, {centre.x - window.x, centre.y - window.y, shape_->radius}, shape_->blur);
  if (!rim || !usable_rim(*rim, *shape_)) return std::nullopt;
  rim->circle.x += window.x;
  rim->circle.y += window.y;
  return rim;
}

void RimTrack::see(FrameSource& source, std::int64_t index, std::size_t place, const Sighting& sighting) {
  if (!shape_) return;
  if (sighting.rim) {
    rows_.push_back({place, false, *sighting.rim});
    return;
  }
  if (!in_sample(seen_++, stride_)) return;
  if (auto rim = measure(source, index, sighting.position)) rows_.push_back({place, true, std::move(*rim)});
}

void RimTrack::measure_all(FrameSource& source, std::int64_t first_index, const Track& track) {
  std::vector<Row> all;
  auto known = rows_.begin();
  for (std::size_t place = 0; place < track.points.size(); ++place) {
    const TrackPoint& p = track.points[place];
    if (known != rows_.end() && known->place == place)
      all.push_back(std::move(*known++));
    else if (p.status == TrackStatus::ok)
      if (auto rim = measure(source, first_index + static_cast<std::int64_t>(place), {p.x, p.y}))
        all.push_back({place, true, std::move(*rim)});
  }
  rows_ = std::move(all);
}

RimEvidence RimTrack::settle(FrameSource& source, FirstPassResult& result, Track& track) {
  RimEvidence evidence;
  result.by_rim.assign(track.points.size(), false);
  if (!shape_) return evidence;
  evidence.frames =
      std::ranges::count(track.points, TrackStatus::ok, [](const TrackPoint& p) { return p.status; });
  const auto fixes = [&] {
    std::vector<RimFrame> rims;
    for (const Row& row : rows_) rims.push_back({static_cast<std::int64_t>(row.place), row.rim});
    return fix_centres(rims, result.noise_variance);
  };
  std::vector<RimFix> fixed = fixes();
  Comparison both;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    if (!rows_[k].by_template)
      ++evidence.rim_only;
    else if (rows_[k].place > 0)  // there the template meets itself
      both.add(track.points[rows_[k].place], fixed[k]);
  }
  evidence.compared = static_cast<std::int64_t>(both.count());
  evidence.rim_px = std::sqrt(both.rim_variance());
  evidence.template_px = std::sqrt(both.template_variance());
  evidence.chosen = both.enough() ? both.rim_variance() < both.template_variance()
                                  : evidence.rim_only > evidence.frames / 2;
  if (evidence.chosen) {
    measure_all(source, result.first_index, track);
    fixed = fixes();
  }
  const Point offset = both.offset();
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Row& row = rows_[k];
    if (row.by_template && !evidence.chosen) continue;
    put(track.points[row.place], fixed[k], row.rim, offset);
    result.by_rim[row.place] = true;
    result.residual[row.place] = row.rim.residual_rms;
  }
  return evidence;
}

}  // namespace tribotrack::vision
