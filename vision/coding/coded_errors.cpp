#include "vision/coding/coded_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "vision/coding_forecast.h"
#include "vision/kernels/dense.h"
#include "vision/kernels/median.h"
#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

constexpr int kBlock = 8;
using Block = std::array<double, kBlock * kBlock>;
/// The largest coefficient of an orthonormal DCT.
double largest_coefficient(Block block) {
  cv::Mat levels(kBlock, kBlock, CV_64F, block.data());
  cv::dct(levels, levels);
  return cv::norm(levels, cv::NORM_INF);
}

struct Mean {
  double sum = 0, weight = 0;
  void add(const Block& slope) {
    double square = 0;
    for (const double s : slope) square += s * s;
    const double largest = largest_coefficient(slope);
    sum += square * largest;
    weight += square;
  }
  double unnoticed() const { return sum > 0 ? weight / sum : 0; }
};

bool counts(const Circle& rim, int left, int top, double margin) {
  const double middle = 0.5 * (kBlock - 1);
  const double off = std::hypot(left + middle - rim.x, top + middle - rim.y) - rim.radius;
  return margin < 0 ? off < middle : std::abs(off) < middle + margin;
}

}  // namespace

Point unnoticed_motion(const Picture& picture, const Circle& rim, double margin) {
  Mean along_x, along_y;
  for (int top = 0; top + kBlock <= picture.height(); top += kBlock)
    for (int left = 0; left + kBlock <= picture.width(); left += kBlock) {
      if (!counts(rim, left, top, margin)) continue;
      Block x{}, y{};
      for (int j = 0; j < kBlock; ++j)
        for (int i = 0; i < kBlock; ++i) {
          const auto level = [&](int dx, int dy) {
            return static_cast<double>(picture.at(std::clamp(left + i + dx, 0, picture.width() - 1),
                                                  std::clamp(top + j + dy, 0, picture.height() - 1)));
          };
          const auto at = static_cast<std::size_t>(j * kBlock + i);
          x[at] = 0.5 * (level(1, 0) - level(-1, 0));
          y[at] = 0.5 * (level(0, 1) - level(0, -1));
        }
      along_x.add(x);
      along_y.add(y);
    }
  return {along_x.unnoticed(), along_y.unnoticed()};
}

namespace {

constexpr double kPlay = 0.58;               ///< half width of the play over d0
constexpr double kMoving = 0.2;              ///< of its variance, where a vector follows the part
constexpr double kVector = 0.125;            ///< px: half of what a vector's last digit stands for
constexpr double kBlocks = 1.4, kStill = 3;  ///< of the measured law

double square(double x) {
  return x * x;
}

double mean(const Point& p) {
  return 0.5 * (p.x + p.y);
}

/// Variances, px^2, along x and y.
using Added = Eigen::Array2d;

Added play_variance(bool still, const Point& unnoticed) {
  return 0.5 * square(kPlay) * (still ? 1 : kMoving) * Added(unnoticed.x, unnoticed.y).square();
}

/// By the measured law, of a variance that the audit has made `white` times as large.
double by_law(double sigma, double white) {
  return std::max(0.0, square(kBlocks + kStill) / white - 1) * square(sigma);
}

/// px a frame, of the part or of the mark; 0 where it is not known.
double speed_at(const std::vector<TrackPoint>& points, std::size_t k, bool of_mark) {
  const std::size_t first = k > 0 ? k - 1 : 0, last = std::min(k + 1, points.size() - 1);
  const TrackPoint &a = points[first], &b = points[last];
  const bool seen =
      of_mark ? a.marker && b.marker : a.status == TrackStatus::ok && b.status == TrackStatus::ok;
  if (!seen || first == last) return 0;
  return (of_mark ? distance(*a.marker, *b.marker) : distance(a, b)) / static_cast<double>(last - first);
}

/// How a frame's coder sees the part or the mark.
struct Sight {
  Point unnoticed;     ///< px
  bool still = false;  ///< predicted from the same place of another frame
};

Sight sight_of(const Coder& coder, const CodedFrame& frame, const Point& for_one_level, double speed) {
  const double zone = coder.dead_zone * frame.step;
  const Point unnoticed{zone * for_one_level.x, zone * for_one_level.y};
  return {unnoticed, frame.type != 'I' && speed < std::max(kVector, mean(unnoticed))};
}

Point mean_position(const Track& track) {
  Point sum;
  double count = 0;
  for (const TrackPoint& p : track.points)
    if (p.status == TrackStatus::ok) sum = {sum.x + p.x, sum.y + p.y}, ++count;
  return {sum.x / std::max(1.0, count), sum.y / std::max(1.0, count)};
}

/// A template's own frame fits itself, and leaves no residual for what the coder did there: it is known no
/// better than the usual frame.
void widen_first(Track& track) {
  const auto is_ok = [](const TrackPoint& p) { return p.status == TrackStatus::ok; };
  const auto first = std::ranges::find_if(track.points, is_ok);
  if (first == track.points.end()) return;
  for (double TrackPoint::*sigma : {&TrackPoint::sigma_x, &TrackPoint::sigma_y}) {
    std::vector<double> sigmas;
    for (const TrackPoint& p : track.points)
      if (is_ok(p)) sigmas.push_back(p.*sigma);
    (*first).*sigma = std::max((*first).*sigma, median(sigmas));
  }
}

/// s over which the direction of motion stays: half the integral of its autocorrelation, both ways.
double direction_time(const Track& track, double step) {
  std::vector<Point> way;
  std::vector<double> time;
  for (const TrackPoint& p : track.points) {
    if (p.status != TrackStatus::ok) continue;
    way.push_back({p.x, p.y});
    time.push_back(p.time_s);
  }
  std::vector<Point> direction;
  for (std::size_t k = 0, last = 0; k < way.size(); ++k) {
    const Point d = {way[k].x - way[last].x, way[k].y - way[last].y};
    const double length = std::hypot(d.x, d.y);
    if (length > step) last = k;
    direction.push_back(length > 0 ? Point{d.x / length, d.y / length} : Point{});
  }
  if (direction.size() < 8) return 0;
  const double interval = (time.back() - time.front()) / static_cast<double>(time.size() - 1);
  double integral = 0;
  for (std::size_t lag = 0; lag < direction.size() / 2; ++lag) {
    double sum = 0;
    for (std::size_t k = 0; k + lag < direction.size(); ++k)
      sum += direction[k].x * direction[k + lag].x + direction[k].y * direction[k + lag].y;
    const double share = sum / static_cast<double>(direction.size() - lag);
    if (share <= 0) break;
    integral += share * interval;
  }
  return integral;
}

/// One sentence for a person.
std::string coding_warning(const CodedErrors& errors) {
  if (!(errors.added_sd > 0)) return {};
  if (!(errors.step > 0))
    return fmt::format(
        "coded as {}, which does not tell how: {:.4f} px that change over {:.2g} s are added to the standard "
        "deviations. Film uncompressed, as FFV1, or code every frame by itself (MJPEG, all-intra)",
        errors.coder, errors.added_sd, errors.slow_time);
  return fmt::format(
      "coded by {}: motion below {:.3f} px is not encoded, and in {:.0f} % of the frames the part moves too "
      "little for a motion vector; {:.4f} px that change over {:.2g} s are added to the standard deviations. "
      "Film uncompressed, as FFV1, or code every frame by itself (MJPEG, all-intra)",
      errors.coder, errors.unnoticed, 100 * errors.still, errors.added_sd, errors.slow_time);
}

}  // namespace

double displacement_differs(const Track& track, const Track& other) {
  const Point here = mean_position(track), there = mean_position(other);
  double squares = 0, products = 0, count = 0;
  const auto both = [&](auto&& look) {
    for (std::size_t k = 0; k < std::min(track.points.size(), other.points.size()); ++k) {
      const TrackPoint &a = track.points[k], &b = other.points[k];
      if (a.status != TrackStatus::ok || b.status != TrackStatus::ok) continue;
      look(a.x - here.x, b.x - there.x);
      look(a.y - here.y, b.y - there.y);
    }
  };
  both([&](double x, double y) {
    squares += x * x;
    products += x * (y - x);
    ++count;
  });
  if (!(squares > 0) || count < 16) return 0;
  const double share = products / squares;
  double left = 0;
  both([&](double x, double y) { left += square(y - x - share * x); });
  const double scatter = std::sqrt(left / count / squares);
  return std::abs(share) > 2 * scatter ? share : 0;
}

void widen_for_coding(const CodedTrack& coded, Track& track, TrackSummary& summary) {
  const Coder& coder = *coded.recording.info().coder;
  const double white = summary.audit.white_factor;
  if (!summary.layered) widen_first(track);
  CodedErrors found{.coder = coder.name, .settings = coder.settings, .known = coder.known};
  const Point middle = mean_position(track);
  double count = 0;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok) continue;
    const CodedFrame* seen = coded.recording.coded(coded.first_index + static_cast<std::int64_t>(k));
    const CodedFrame frame = seen ? *seen : CodedFrame{};
    const Sight part = sight_of(coder, frame, coded.part_unnoticed, speed_at(track.points, k, false)),
                mark = sight_of(coder, frame, coded.mark_unnoticed, speed_at(track.points, k, true));
    Added added{0, 0};
    if (!coder.all_intra && frame.type != 'I')
      added = frame.step > 0 ? play_variance(part.still, part.unnoticed)
                             : Added(by_law(p.sigma_x, white), by_law(p.sigma_y, white));
    added += (coded.passes_differ * Eigen::Array2d(p.x - middle.x, p.y - middle.y)).square();
    set_covariance(p, covariance_of(p) + Eigen::Matrix2d(added.matrix().asDiagonal()));
    ++count;
    found.step += frame.step;
    found.unnoticed += mean(part.unnoticed);
    found.added_sd += added.mean();
    if (coder.all_intra) continue;
    (part.still ? found.still : found.moving) += frame.type != 'I';
    found.part_play += part.still ? kPlay * mean(part.unnoticed) : 0;
    found.mark_play += mark.still ? kPlay * mean(mark.unnoticed) : 0;
  }
  for (double* sum : {&found.step, &found.still, &found.moving, &found.unnoticed, &found.part_play,
                      &found.mark_play, &found.added_sd})
    *sum /= std::max(1.0, count);
  found.added_sd = std::sqrt(found.added_sd);
  if (!(found.step > 0)) found.part_play = found.mark_play = std::numbers::sqrt2 * found.added_sd;
  found.slow_time = found.added_sd > 0 ? direction_time(track, found.unnoticed) : 0;
  if (found.added_sd > 0 && found.slow_time > 0)
    summary.slow.push_back({"coder", found.added_sd, found.slow_time});
  if (std::string warning = coding_warning(found); !warning.empty())
    summary.warnings.push_back(std::move(warning));
  summary.coded = std::move(found);
}

namespace {

constexpr double kPredicted = 0.3,
                 kByItself = 0.08;  ///< errors in steps over the contrast, see coding_forecast.h

std::string advice_for(const Coder& coder) {
  if (coder.all_intra) return "every frame is coded by itself, which is the best a lossy coding can do";
  return "film uncompressed or as FFV1; else MJPEG of high quality, or H.264 with every frame coded by "
         "itself "
         "(-g 1, crf 18 or less)";
}

}  // namespace

std::optional<CodingForecast> forecast(const Coder& coder, double contrast) {
  if (!(coder.step > 0) || !(contrast > 0)) return std::nullopt;
  const double step = coder.step / contrast;
  return CodingForecast{(coder.all_intra ? kByItself : kPredicted) * step,
                        coder.all_intra ? 0 : coder.dead_zone * step / std::numbers::sqrt2,
                        advice_for(coder)};
}

}  // namespace tribotrack::vision
